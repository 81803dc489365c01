"""Runs the measured programs, pinned to one core, one after the other, and reads their JSON lines."""
import json
import os
import pathlib
import shutil
import subprocess

PEERS = pathlib.Path(__file__).resolve().parent / "peers"


class Refused(Exception):
    """A program cannot do what it was asked, or takes too long; its text says why."""


class Programs:
    """Those of a build folder (tools/bench of it) and of its subfolder peers; scripts (.py) of peers/, which run by the
    interpreter LITHE_PEERS_PYTHON (python3 without it)."""

    def __init__(self, folder, core=0):
        self.folder = pathlib.Path(folder)
        self.pin = ["taskset", "-c", str(core)] if shutil.which("taskset") else []
        self.python = os.environ.get("LITHE_PEERS_PYTHON", "python3")

    def imports(self, module):
        """Whether the interpreter of peers has it."""
        return subprocess.run([self.python, "-c", f"import {module}"], capture_output=True).returncode == 0

    def find(self, name):
        for path in (self.folder / name, self.folder / "peers" / name, PEERS / name):
            if path.exists():
                return path
        return None

    def lines(self, name, *arguments, timeout=120, pinned=True):
        """The JSON lines of one call, on one core unless it is not pinned. Raises Refused with the program's last words."""
        path = self.find(name)
        if path is None:
            raise Refused("not built: its package is missing" if name.endswith("_driver") else "not built")
        command = [*(self.pin if pinned else []), *([self.python] if path.suffix == ".py" else []), str(path), *map(str, arguments)]
        try:
            done = subprocess.run(command, capture_output=True, text=True, timeout=timeout)
        except subprocess.TimeoutExpired:
            raise Refused(f"not done within {timeout:.0f} s") from None
        lines = [line for line in done.stdout.splitlines() if line.startswith("{")]
        if done.returncode or not lines:
            words = done.stderr.strip().splitlines()
            raise Refused(words[-1] if words else f"{name} ended with code {done.returncode}")
        return [json.loads(line) for line in lines]

    def run(self, name, *arguments, timeout=120, pinned=True):
        return self.lines(name, *arguments, timeout=timeout, pinned=pinned)[-1]


def repeats_of(seconds):
    """Runs within one process, so that short ones are warm."""
    return 5 if seconds < 0.02 else 2 if seconds < 0.2 else 1


def rounds_of(seconds, most=5):
    """Processes by turns: least of five, of fewer where a run costs seconds."""
    return most if seconds < 1 else min(most, 3) if seconds < 3 else min(most, 2)


def by_turns(programs, jobs, value, rounds):
    """The cheapest row of each job, all of them by turns so that none has the machine's good minute to itself.

    jobs: {name: (program, arguments)}; value(row): what is to be least; rounds: {name: how often} or one number.
    """
    best = {}
    most = rounds if isinstance(rounds, int) else max(rounds.values(), default=0)
    for turn in range(most):
        for name, (program, arguments) in jobs.items():
            if not isinstance(rounds, int) and turn >= rounds[name]:
                continue
            row = programs.run(program, *arguments)
            if name not in best or value(row) < value(best[name]):
                best[name] = row
    return best
