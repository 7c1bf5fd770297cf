"""A program that passes for ``mfixsolver``. It is not MFiX, and proves nothing about it.

It keeps to what is read in the source of MFiX 21.3.2 (written anew, in two dimensions): the
contact with m_eff = m/2 and its step (``check_solids_dem.f``), forces and the pairs that count
twice (``calc_force_dem.f``, ``desgrid_mod.f``), the scheme (``cfnewvalues.f``), the mass outflow
(``mass_outflow_dem.f``), when output is due (``output_manager.f``) and its form (``vtp_mod.f``).

Run as ``python stand_in.py MODE OPTIONS...``. At a restitution of 0.25 it does what MODE says.
"""

import math
import os
import re
import signal
import struct
import sys
import time
from pathlib import Path

NORMAL, EXITING, GONE = "normal", "exiting", "gone"
SMALL = 1e-15
VERSIONS = {"0.0": " 0.0", "blank": " " * 11}
HELP = """ Usage: mfixsolver [-h,--help] [-p,--print-flags] [-f,--file <filename>]
        -f,--file <filename>: specify filename of input file (Default: mfix.dat)
        <KEYWORD>=<VALUE>: specify keyword on command line, overrides values in input desk"""
AFTER = ("half a file", "stops early")
"""What goes wrong after the run."""


REFUSALS = {
    "refuse": "Error 1000: Required input not specified: KN",
    "unknown": "Illegal or unknown input: DES_EN_INPUT = 0.25",
    "invalid": "Invalid particle-particle collision model: LSD",
}
"""Refusals with a number and without (``check_solids_dem.f``)."""


NAMELISTS = (
    "RUN_NAME",
    "RUN_TYPE UNITS TIME ENERGY_EQ SPECIES_EQ",
    "DESCRIPTION TSTOP DT MOMENTUM_X_EQ MOMENTUM_Y_EQ MOMENTUM_Z_EQ",
    "CALL_USR C",
    "GRAVITY_X GRAVITY_Y GRAVITY_Z",
    "COORDINATES XLENGTH IMAX YLENGTH JMAX ZLENGTH NO_K CYCLIC_X",
    "RO_G0 MU_G0",
    "MMAX SOLIDS_MODEL",
    "D_P0 RO_S0",
    "PARTICLES DES_COLL_MODEL MEW MEW_W KN KN_W KT_FAC KT_W_FAC DES_ETAT_FAC DES_ETAT_W_FAC"
    " DES_EN_INPUT DES_EN_WALL_INPUT DES_INTG_METHOD DTSOLID_FACTOR"
    " DESGRIDSEARCH_IMAX DESGRIDSEARCH_JMAX",
    "IC_X_W IC_X_E IC_Y_S IC_Y_N IC_EP_G IC_P_G IC_U_G IC_V_G IC_W_G",
    "BC_TYPE BC_X_W BC_X_E BC_Y_S BC_Y_N",
    "BC_DT_0 BC_U_G BC_V_G BC_W_G BC_U_S BC_V_S BC_W_S",
    "FULL_LOG",
    "RES_DT NLOG VTK_FILEBASE VTK_DATA VTK_DT VTK_X_W VTK_X_E VTK_Y_S VTK_Y_N"
    " VTK_PART_VEL VTK_PART_ID",
    "WRITE_VTK_FILES TIME_DEPENDENT_FILENAME",
)
"""Keywords that a line may hold together (``include/*.inc``, ``read_namelist.f``)."""


PAIR = re.compile(r"([A-Za-z_]\w*(?:\([\d:, ]+\))?)\s*=\s*")


def read_keywords(text):
    """Return the values by keyword, in capitals, of a file; refuse lines that MFiX would."""
    keywords = {}
    for number, line in enumerate(text.splitlines(), 1):
        line = re.split(r"[!#]", line)[0]
        pairs = list(PAIR.finditer(line))
        names = {pair[1].upper().partition("(")[0] for pair in pairs}
        if len(line) > 160 or not any(names <= set(one.split()) for one in NAMELISTS):
            sys.exit(f"Error 2000: Unable to process line {number} of the project file.")
        ends = [pair.start() for pair in pairs[1:]] + [len(line)]
        for pair, end in zip(pairs, ends, strict=bool(pairs)):
            values = [value_of(word) for word in line[pair.end() : end].split()]
            key = pair[1].upper().replace(" ", "")
            assert key not in keywords, key
            keywords[key] = values[0] if len(values) == 1 else values
    return keywords


def value_of(word):
    if word.startswith("'"):
        return word.strip("'")
    if word.upper().strip(".") in ("T", "TRUE", "F", "FALSE"):
        return word.upper().strip(".")[0] == "T"
    return float(re.sub("[dD]", "e", word))


class Particle:
    def __init__(self, number, line):
        self.number, self.state = number, NORMAL
        self.x, self.y, self.radius, self.density, self.vx, self.vy = map(float, line)
        self.mass = self.density * 4 / 3 * math.pi * self.radius**3


class Run:
    def __init__(self, keys, lines):
        self.keys, self.time, self.frames, self.chain = keys, keys.get("TIME", 0.0), {}, []
        lines = [line.replace("d", "e").split() for line in lines][: int(keys["PARTICLES"])]
        self.particles = [Particle(i, line) for i, line in enumerate(lines, 1)]
        mass = math.pi / 6 * keys["D_P0(1)"] ** 3 * keys["RO_S0(1)"]
        half, k = mass * mass / (mass + mass), keys["KN"]
        log = math.log(keys["DES_EN_INPUT"])
        self.stiffness = k
        self.eta = 2 * math.sqrt(k * half) * abs(log) / math.sqrt(math.pi**2 + log**2)
        contact = math.pi / math.sqrt(k / half - (self.eta / half) ** 2 / 4)
        self.step = contact / keys["DTSOLID_FACTOR"]
        steps = (keys["TSTOP"] - self.time) / self.step
        self.steps = math.ceil(struct.unpack("f", struct.pack("f", steps))[0])
        self.due = {}
        self.seen = 0.5 * min(self.search_cell("X", "I"), self.search_cell("Y", "J"))

    def search_cell(self, axis, index):
        """Return the width of the cells of the search, which looks half a cell about a particle."""
        length, widest = self.keys[f"{axis}LENGTH"], 3.0 * self.keys["D_P0(1)"]
        widest = min(widest, length / self.keys[f"{index}MAX"])
        return length / self.keys.get(f"DESGRIDSEARCH_{index}MAX", max(int(length / widest), 1))

    def march(self):
        self.output()
        for _ in range(self.steps):
            self.forces()
            self.move()
            if self.keys.get("BC_TYPE(1)") == "MO":
                self.outflow()
            self.time += self.step
            self.output()

    def forces(self):
        self.chain = []
        self.total = {p.number: [0.0, 0.0] for p in self.particles}
        for p in self.particles:
            if p.state is GONE:
                continue
            for q in self.particles:
                # a pair is found from the first of it; one that leaves is found from both
                if q is p or q.state is GONE or (q.number < p.number and q.state is NORMAL):
                    continue
                self.contact(p, q)

    def contact(self, p, q):
        dx, dy = q.x - p.x, q.y - p.y
        square, reach = dx * dx + dy * dy, p.radius + q.radius
        if square > min(reach - SMALL, self.seen) ** 2:
            return
        distance = math.sqrt(square)
        nx, ny = dx / distance, dy / distance
        closing = (p.vx - q.vx) * nx + (p.vy - q.vy) * ny
        push = -(self.stiffness * (reach - distance) + self.eta * closing)
        for particle, sign in ((p, 1.0), (q, -1.0)):
            self.total[particle.number][0] += sign * push * nx
            self.total[particle.number][1] += sign * push * ny
        self.chain.append((0.5 * (p.x + q.x), 0.5 * (p.y + q.y), push * nx, push * ny))

    def move(self):
        for p in self.particles:
            if p.state is NORMAL:
                fx, fy = self.total[p.number]
                p.vx += self.step * (fx / p.mass + self.keys["GRAVITY_X"])
                p.vy += self.step * (fy / p.mass + self.keys["GRAVITY_Y"])
            p.x += p.vx * self.step
            p.y += p.vy * self.step

    def outflow(self):
        for p in self.particles:
            if p.state is GONE:
                continue
            if p.y > p.radius:
                p.state = NORMAL
            elif p.y > 0:
                p.vx, p.vy = self.keys["BC_U_S(1,1)"], self.keys["BC_V_S(1,1)"]
                p.state = EXITING
            else:
                p.state = GONE

    def output(self):
        for region in (1, 2):
            if f"VTK_DT({region})" not in self.keys:
                continue
            now, interval = self.time + 0.1 * self.step, self.keys[f"VTK_DT({region})"]
            if now < self.due.get(region, 0.0) and now < self.keys["TSTOP"]:
                continue
            self.due[region] = (int(now / interval) + 1) * interval
            self.write(region)

    def write(self, region):
        frame = self.frames[region] = self.frames.get(region, -1) + 1
        name = f"{self.keys[f'VTK_FILEBASE({region})']}_{frame:04d}.vtp"
        if self.keys[f"VTK_DATA({region})"] == "P":
            seen = [p for p in self.particles if p.state is NORMAL]
            places = [(p.x, p.y, 0.0) for p in seen]
            fields = {
                "Velocity": [(p.vx, p.vy, 0.0) for p in seen],
                "Particle_ID": [(float(p.number),) for p in seen],
            }
        else:
            places = [(x, y, 0.0) for x, y, _, _ in self.chain]
            sizes = [(math.hypot(fx, fy),) for *_, fx, fy in self.chain]
            fields = {
                "FORCE_CHAIN_FN_MAG": sizes,
                "FORCE_CHAIN_FN": [(fx, fy, 0.0) for *_, fx, fy in self.chain],
            }
        if places:
            Path(name).write_bytes(vtp(self.time, places, fields))


def vtp(now, places, fields):
    """Return a file as MFiX writes it: an XML head, then blocks in single precision."""
    arrays = {"coordinates": places, **fields}
    head = [
        '<?xml version="1.0"?>',
        f" <!-- Time =  {now:.16E}      sec. -->",
        '<VTKFile type="PolyData" version="0.1" byte_order="BigEndian">',
        "  <PolyData>",
        f'     <Piece NumberOfPoints="{len(places):12d} "  NumberOfVerts="           0 '
        '" NumberOfLines ="0" NumberOfStrips="0" NumberOfPolys="0" >',
        "       <Points>",
    ]
    blocks = b""
    for name, rows in arrays.items():
        values = [value for row in rows for value in row]
        components = '  NumberOfComponents="3"' if len(rows[0]) == 3 else ""
        head.append(
            f'        <DataArray type="Float32" Name="{name}"{components} format="appended" '
            f'offset="{len(blocks):12d}" />'
        )
        if name == "coordinates":
            head += ["       </Points>", '<PointData Scalars="Diameter" Vectors="Velocity"> ']
        blocks += struct.pack(f">i{len(values)}f", 4 * len(values), *values)
    head += ["       </PointData>", "       <Verts> </Verts>", "     </Piece>", "   </PolyData>"]
    count = len(places)
    tail = b"".join(struct.pack(f">q{count}q", 8 * count, *range(i, count + i)) for i in (0, 1))
    text = "\n".join([*head, '   <AppendedData encoding="raw">', " _"])
    return text.encode() + blocks + tail + b"\n   </AppendedData>\n </VTKFile>\n"


def misbehave(mode):
    if mode.startswith("SIG"):
        os.kill(os.getpid(), getattr(signal, mode))
    elif mode == "hang":
        time.sleep(60)
    elif mode in REFUSALS:
        print(f">>>>>----\n{REFUSALS[mode]}\nPlease correct the project settings.")
        sys.exit(1)
    paths = sorted(Path().glob("GRAIN_*.vtp"))
    if mode == "half a file":
        content = paths[-1].read_bytes()
        paths[-1].write_bytes(content[: len(content) // 2])
    elif mode == "stops early":
        for path in paths[50:]:
            path.unlink()


def main(mode, options):
    if "--help" in options:
        print("hello" if mode == "another" else HELP)
        return
    if "--version" in options:
        print(VERSIONS.get(mode, " 21.3.2"))
        return
    keys = read_keywords(Path(options[options.index("-f") + 1]).read_text(encoding="utf-8"))
    if list(Path().glob("*.RES")):
        print("Error 1102: a restart file is here, and RUN_TYPE is NEW")
        sys.exit(1)
    Path(f"{keys['RUN_NAME']}.RES").write_text("restart", encoding="utf-8")
    if mode == "no hold":
        keys.pop("BC_TYPE(1)", None)
    bad = math.isclose(keys["DES_EN_INPUT"], 0.25, rel_tol=1e-9)
    if not bad or mode in (*AFTER, ""):
        lines = Path("particle_input.dat").read_text(encoding="utf-8").splitlines()
        Run(keys, lines).march()
    if bad and mode:
        misbehave(mode)


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2:])
