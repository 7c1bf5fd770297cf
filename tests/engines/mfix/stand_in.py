"""A program that passes for ``mfixsolver``. It is not MFiX, and proves nothing about it.

It keeps to what is read in the source of MFiX 21.3.2 (written anew, in two dimensions): the
contact with m_eff = m/2 and its step (``check_solids_dem.f``), forces and the pairs that count
twice (``calc_force_dem.f``, ``desgrid_mod.f``), the scheme (``cfnewvalues.f``), the mass outflow
(``mass_outflow_dem.f``), when output is due (``output_manager.f``) and its form (``vtp_mod.f``).

Run as ``python stand_in.py MODE OPTIONS...``. Where the restitution is one of ``FAULTS``, it fails.
"""

import math
import os
import re
import signal
import sys
from pathlib import Path

if not {"--help", "--version"} & {*sys.argv}:  # asked without it, which takes most of the time
    import numpy as np

VERSIONS = {"0.0": " 0.0", "blank": " " * 11}
HELP = " Usage: mfixsolver [-f,--file <filename>] (Default: mfix.dat)\n        <KEYWORD>=<VALUE>"
FAULTS = {  # a signal, or a refusal with a number and without (``check_solids_dem.f``)
    0.25: signal.SIGFPE,
    0.26: "Error 1000: Required input not specified: KN",
    0.27: "Illegal or unknown input: DES_EN_INPUT = 0.27",
}
PAIR = re.compile(r"([A-Za-z_]\w*(?:\([\d:, ]+\))?)\s*=\s*")


def read_keywords(text):
    """Return the values by keyword, in capitals, of a file."""
    keywords = {}
    for line in text.splitlines():
        words = PAIR.split(re.split(r"[!#]", line)[0])[1:]
        for name, values in zip(words[::2], words[1::2], strict=True):
            key = name.upper().replace(" ", "")
            assert key not in keywords, key
            each = [value_of(word) for word in values.split()]
            keywords[key] = each[0] if len(each) == 1 else each
    return keywords


def value_of(word):
    if word.startswith("'"):
        return word.strip("'")
    if word.upper().strip(".") in ("T", "TRUE", "F", "FALSE"):
        return word.upper().strip(".")[0] == "T"
    return float(re.sub("[dD]", "e", word))


class Run:
    """Particles by their numbers from 1 on; those that ``exit`` take the outflow's velocity."""

    def __init__(self, keys, table):
        self.keys, self.time, self.frames = keys, 0.0, {"P": 0, "F": 0}
        self.x, self.radius, self.v = table[:, :2], table[:, 2], table[:, 4:6]
        self.mass = (table[:, 3] * 4 / 3 * math.pi * self.radius**3)[:, None]
        self.exits = np.zeros(len(table), bool)
        half, k, log = 0.5 * self.mass[0, 0], keys["KN"], math.log(keys["DES_EN_INPUT"])
        self.eta = 2 * math.sqrt(k * half) * abs(log) / math.hypot(math.pi, log)
        contact = math.pi / math.sqrt(k / half - (self.eta / half) ** 2 / 4)
        self.step = contact / keys["DTSOLID_FACTOR"]
        # the search looks half a cell about a particle
        cells = [keys[f"{a}LENGTH"] / keys[f"DESGRIDSEARCH_{i}MAX"] for a, i in ("XI", "YJ")]
        self.reach = np.minimum(self.radius[:, None] + self.radius, 0.5 * min(cells))
        self.gravity = np.array([keys["GRAVITY_X"], keys["GRAVITY_Y"]])

    def march(self):
        """Take all steps; frames come every interval of steps, and of the last one."""
        steps = math.ceil(np.float32(self.keys["TSTOP"] / self.step))
        every = round(self.keys["VTK_DT(1)"] / self.step)
        self.write("P", [])
        for number in range(1, steps + 1):
            contacts = self.move()
            if "BC_TYPE(1)" in self.keys:
                self.exits = self.x[:, 1] <= self.radius
                self.v[self.exits] = self.keys["BC_U_S(1,1)"], self.keys["BC_V_S(1,1)"]
            self.time = number * self.step
            if number % every == 0 or number == steps:
                self.write("P", [])
                if "VTK_DATA(2)" in self.keys:
                    self.write("F", contacts)

    def move(self):
        """Take a step; return place and force of each contact."""
        apart = self.x[None] - self.x[:, None]
        distance = np.hypot(apart[..., 0], apart[..., 1])
        i, j = np.nonzero(np.triu(distance <= self.reach - 1e-15, 1))
        normal = apart[i, j] / distance[i, j, None]
        closing = ((self.v[i] - self.v[j]) * normal).sum(axis=1)
        overlap = self.radius[i] + self.radius[j] - distance[i, j]
        push = -(self.keys["KN"] * overlap + self.eta * closing)[:, None] * normal
        total = np.zeros_like(self.x)
        # a pair is found from the first of it; one that exits is found from both
        counted = push * (1.0 + self.exits[i, None])
        np.add.at(total, i, counted)
        np.add.at(total, j, -counted)
        moves = ~self.exits
        self.v[moves] += self.step * (total / self.mass + self.gravity)[moves]
        middles = 0.5 * (self.x[i] + self.x[j])
        self.x += self.step * self.v
        return [(middle, force) for middle, force in zip(middles, push, strict=True)]

    def write(self, data, contacts):
        """Write a frame of particles that do not exit, or of contacts."""
        seen = np.flatnonzero(~self.exits)
        places = self.x[seen] if data == "P" else np.array([middle for middle, _ in contacts])
        fields = {"Velocity": self.v[seen], "Particle_ID": seen[:, None] + 1.0}
        if data == "F":
            fields = {"FORCE_CHAIN_FN": np.array([force for _, force in contacts])}
        if len(places):
            name = self.keys[f"VTK_FILEBASE({'PF'.index(data) + 1})"]
            content = vtp(self.time, places, fields)
            Path(f"{name}_{self.frames[data]:04d}.vtp").write_bytes(content)
        self.frames[data] += 1


def vtp(now, places, fields):
    """Return a file as MFiX writes it: an XML head, then blocks in single precision.

    Vectors in the plane get a third component.
    """
    head = [
        f'<?xml version="1.0"?>\n <!-- Time =  {now:.16E}      sec. -->',
        '<VTKFile type="PolyData" version="0.1" byte_order="BigEndian">\n  <PolyData>',
        f'     <Piece NumberOfPoints="{len(places):12d} "  NumberOfVerts="           0 ">',
    ]
    blocks = b""
    for name, rows in {"coordinates": places, **fields}.items():
        flat = rows if rows.shape[1] == 1 else np.pad(rows, ((0, 0), (0, 1)))
        components = "" if rows.shape[1] == 1 else '  NumberOfComponents="3"'
        head.append(
            f'        <DataArray type="Float32" Name="{name}"{components} format="appended" '
            f'offset="{len(blocks):12d}" />'
        )
        values = flat.astype(">f4").tobytes()
        blocks += len(values).to_bytes(4, "big") + values
    text = "\n".join([*head, "   </PolyData>", '   <AppendedData encoding="raw">', " _"])
    return text.encode() + blocks + b"\n   </AppendedData>\n </VTKFile>\n"


def misbehave(fault):
    if isinstance(fault, signal.Signals):
        os.kill(os.getpid(), fault)
    sys.exit(f">>>>>----\n{fault}\nPlease correct the project settings.")


def main(mode, options):
    if "--help" in options:
        print("hello" if mode == "another" else HELP)
        return
    if "--version" in options:
        print(VERSIONS.get(mode, " 21.3.2"))
        return
    keys = read_keywords(Path(options[options.index("-f") + 1]).read_text(encoding="utf-8"))
    if mode == "no hold":
        keys.pop("BC_TYPE(1)", None)
    if fault := FAULTS.get(round(keys["DES_EN_INPUT"], 9)):
        misbehave(fault)
    text = Path("particle_input.dat").read_text(encoding="utf-8").replace("d", "e")
    Run(keys, np.array([line.split() for line in text.splitlines()], float)).march()


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2:])
