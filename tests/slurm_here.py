"""A real SLURM of this machine, in a folder of its own, for the tests that need one."""

import os
import shutil
import socket
import subprocess
import tempfile
import time
from pathlib import Path

import pytest

PROGRAMS = ("munged", "slurmctld", "slurmd", "sbatch", "srun")
DAEMONS = ("slurmd", "slurmctld", "munged")
MOST_MINUTES = 100

CONFIGURATION = """
ClusterName=test
SlurmctldHost={host}(127.0.0.1)
SlurmctldPort={ports[0]}
SlurmdPort={ports[1]}
SlurmUser=root
SlurmdUser=root
AuthType=auth/munge
AuthInfo=socket={folder}/munge.socket
CredType=cred/munge
ProctrackType=proctrack/pgid
TaskPlugin=task/none
JobAcctGatherType=jobacct_gather/none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
ReturnToService=2
UnkillableStepTimeout=600
SlurmctldPidFile={folder}/slurmctld.pid
SlurmdPidFile={folder}/slurmd.pid
SlurmctldLogFile={folder}/slurmctld.log
SlurmdLogFile={folder}/slurmd.log
StateSaveLocation={folder}/state
SlurmdSpoolDir={folder}/spool
NodeName={host} NodeAddr=127.0.0.1 CPUs=2 RealMemory=1000
PartitionName=p Nodes={host} Default=YES State=UP MaxTime={minutes}
"""


def free_ports(count):
    taken = [socket.socket() for _ in range(count)]
    for one in taken:
        one.bind(("127.0.0.1", 0))
    ports = [one.getsockname()[1] for one in taken]
    for one in taken:
        one.close()
    return ports


def start(folder, environment):
    (folder / "munge.key").write_bytes(os.urandom(1024))
    (folder / "munge.key").chmod(0o400)
    for name in ("state", "spool"):
        (folder / name).mkdir()
    names = {"key-file": "munge.key", "socket": "munge.socket", "pid-file": "munged.pid"}
    names |= {"log-file": "munged.log", "seed-file": "munge.seed"}
    words = [f"--{option}={folder / name}" for option, name in names.items()]
    subprocess.run(["munged", "--force", *words], check=True, capture_output=True, timeout=60)
    text = CONFIGURATION.format(
        host=socket.gethostname().partition(".")[0],
        ports=free_ports(2),
        folder=folder,
        minutes=MOST_MINUTES,
    )
    Path(environment["SLURM_CONF"]).write_text(text, encoding="utf-8")
    for daemon in ("slurmctld", "slurmd"):
        subprocess.run(
            [daemon, "-f", environment["SLURM_CONF"]],
            env=environment,
            check=True,
            capture_output=True,
            timeout=60,
        )


def is_idle(environment):
    said = subprocess.run(
        ["sinfo", "--noheader", "--format=%T"], env=environment, capture_output=True, timeout=60
    )
    return said.stdout.strip() == b"idle"


def end(folder):
    for daemon in DAEMONS:
        pid = folder / f"{daemon}.pid"
        if pid.is_file():
            subprocess.run(["kill", pid.read_text().strip()], check=False, capture_output=True)
    time.sleep(1.0)


@pytest.fixture(scope="module")
def slurm():
    """Start munge and SLURM as root, without systemd; skip, with the reason, where none can be."""
    missing = [name for name in PROGRAMS if shutil.which(name) is None]
    if missing:
        pytest.skip(f"no {', '.join(missing)}: apt-get install slurm-wlm munge")
    pytest.importorskip("submitit", reason="pip install 'dem-harness[slurm]'")
    if os.geteuid() != 0:
        pytest.skip("SLURM's daemons are started by root only")
    # short, as the path of a socket must be, and open to others, as munge wants it
    folder = Path(tempfile.mkdtemp(prefix="dh-slurm-"))
    folder.chmod(0o755)
    environment = {**os.environ, "SLURM_CONF": str(folder / "slurm.conf")}
    try:
        start(folder, environment)
        until = time.monotonic() + 60.0
        while not is_idle(environment):
            assert time.monotonic() < until, (folder / "slurmctld.log").read_text()
            time.sleep(0.5)
        with pytest.MonkeyPatch.context() as patch:
            patch.setenv("SLURM_CONF", environment["SLURM_CONF"])
            yield folder
        subprocess.run(["scancel", "--user=root"], env=environment, check=False, timeout=60)
    finally:
        end(folder)
        shutil.rmtree(folder, ignore_errors=True)
