#!/usr/bin/env python3
"""Runs the jobs of render/farm: the template with Open Job Description's own runner, the script with Slurm's.

Usage: farm.py RENDER, RENDER the path of the render program.

A small walk of the glossy box is filled in two chunks and drawn in three. Then frames are lost, one is cut short, and the step
that draws runs again; the frames must have the same bytes. Fails where they do not, or where a job ends with an error. Where Slurm is
installed and the script runs as root, a cluster of one node is started on the loopback: every step is tried with
`sbatch --test-only`, then the walk is drawn, with the same bytes again.
"""

import contextlib
import os
import pathlib
import shutil
import socket
import subprocess
import sys
import tempfile
import time

ROOT = pathlib.Path(__file__).resolve().parents[2]
FARM = ROOT / "render" / "farm"
SCENE = ROOT / "tests" / "scenes" / "cornell-glossy.xml"
PATH = ROOT / "tests" / "scenes" / "cornell-walk.csv"
LAST = 60
OPTIONS = "--method auto --width 32 --tau 0.2 --spp 1"


def openjd(render, out):
    if not shutil.which("openjd"):
        return print("skipped: Open Job Description (pip install openjd-cli)")
    parameters = {
        "Scene": SCENE, "Path": PATH, "Out": out, "Last": LAST, "FillChunk": 30, "DrawChunk": 20, "Render": render,
        "Options": OPTIONS,
    }
    given = [part for name, value in parameters.items() for part in ("-p", f"{name}={value}")]

    def run(*step):
        command = ["openjd", "run", str(FARM / "walk.template.yaml"), *step, *given]
        done = subprocess.run(command, capture_output=True, text=True)
        if done.returncode != 0:
            sys.exit(f"openjd ended with {done.returncode}:\n{done.stdout[-4000:]}{done.stderr[-2000:]}")
        return done.stdout

    log = run("--step", "Draw", "--run-dependencies")
    frames = {path.name: path.read_bytes() for path in out.glob("*.exr")}
    assert len(frames) == LAST, f"{len(frames)} frames"
    assert "openjd_progress: " in log, "no progress was told"
    (out / "0007.exr").unlink()
    (out / "0030.exr").write_bytes(frames["0030.exr"][:1000])
    log = run("--step", "Draw")
    again = {path.name: path.read_bytes() for path in out.glob("*.exr")}
    assert again == frames, "frames that were drawn again differ"
    assert "19 were there" in log, "frames that were there were drawn again"
    print(f"Open Job Description: {LAST} frames, two of them lost and drawn again: the same bytes")
    return frames


CONFIGURATION = """ClusterName=test
SlurmctldHost={host}(127.0.0.1)
AuthType=auth/none
CredType=cred/none
SlurmUser=root
SlurmdUser=root
StateSaveLocation={folder}/state
SlurmdSpoolDir={folder}/spool
SlurmctldPidFile={folder}/slurmctld.pid
SlurmdPidFile={folder}/slurmd.pid
SlurmctldLogFile={folder}/slurmctld.log
SlurmdLogFile={folder}/slurmd.log
SlurmctldPort={ports[0]}
SlurmdPort={ports[1]}
CommunicationParameters=NoCtldInAddrAny,NoInAddrAny
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
SchedulerParameters=sched_interval=1,batch_sched_delay=0
MpiDefault=none
JobAcctGatherType=jobacct_gather/none
AccountingStorageType=accounting_storage/none
NodeName={host} NodeAddr=127.0.0.1 CPUs={cores} State=UNKNOWN
PartitionName=all Nodes=ALL Default=YES MaxTime=INFINITE State=UP
"""


@contextlib.contextmanager
def cluster(folder):
    """A Slurm of one node on the loopback, gone at the end; yields the environment of its commands."""
    for name in ["state", "spool"]:
        (folder / name).mkdir(parents=True)
    sockets = [socket.socket() for _ in range(2)]
    for each in sockets:
        each.bind(("127.0.0.1", 0))
    ports = [each.getsockname()[1] for each in sockets]
    for each in sockets:
        each.close()
    # Slurm wants the short name of the host.
    host = socket.gethostname().split(".")[0]
    configuration = folder / "slurm.conf"
    configuration.write_text(CONFIGURATION.format(host=host, folder=folder, ports=ports, cores=os.cpu_count()))
    environment = os.environ | {"SLURM_CONF": str(configuration)}
    daemons = []
    try:
        for name in ["slurmctld", "slurmd"]:
            with open(folder / f"{name}.out", "wb") as log:
                command = [shutil.which(name), "-D"]
                daemons.append(subprocess.Popen(command, env=environment, stdout=log, stderr=log))
            time.sleep(2)
        for _ in range(30):
            state = subprocess.run(["sinfo", "-h", "-o", "%T"], env=environment, capture_output=True, text=True)
            if "idle" in state.stdout:
                break
            time.sleep(1)
        else:
            sys.exit(f"Slurm does not start: {state.stdout}{state.stderr}{(folder / 'slurmd.out').read_text()[-1000:]}")
        yield environment
    finally:
        for daemon in reversed(daemons):
            daemon.terminate()
            daemon.wait()


def slurm(render, out):
    if not all(map(shutil.which, ["sbatch", "slurmctld", "slurmd"])) or os.geteuid() != 0:
        return print("skipped: Slurm (apt install slurm-wlm, as root)")
    frames = out / "frames"
    settings = {
        "SCENE": str(SCENE), "CAMERA_PATH": str(PATH), "OUT": str(frames), "LAST": str(LAST), "RENDER": render,
        "OPTIONS": OPTIONS, "FILL_CHUNK": "30", "DRAW_CHUNK": "20",
    }
    with cluster(out / "slurm") as environment:
        script = str(FARM / "walk.slurm.sh")
        for step in ["tables", "fill", "merge", "draw"]:
            command = ["sbatch", "--test-only", "--array=0-1", script, step]
            subprocess.run(command, env=environment | settings, check=True, capture_output=True)
        subprocess.run([script], env=environment | settings, check=True, capture_output=True)
        for _ in range(300):
            left = subprocess.run(["squeue", "-h"], env=environment, capture_output=True, text=True).stdout
            if not left.strip():
                break
            time.sleep(1)
        else:
            sys.exit(f"Slurm: jobs hang:\n{left}")
    drawn = {path.name: path.read_bytes() for path in frames.glob("*.exr")}
    logs = "".join(path.read_text()[-500:] for path in sorted((frames / "log").glob("*.txt")))
    assert len(drawn) == LAST, f"{len(drawn)} frames:\n{logs}"
    print(f"Slurm: sbatch --test-only takes every step; {LAST} frames were drawn on one node")
    return drawn


def main():
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    render = os.path.abspath(sys.argv[1])
    with tempfile.TemporaryDirectory() as folder:
        frames = openjd(render, pathlib.Path(folder) / "openjd")
        others = slurm(render, pathlib.Path(folder) / "slurm")
        if frames and others:
            assert frames == others, "the jobs draw different frames"
            print("both draw the same bytes")


main()
