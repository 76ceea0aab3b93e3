"""Whether a command that is killed at a random moment leaves whole files, and ends with the same results when repeated.

python -m benchmarks.kills              60 kills, by SIGKILL and SIGINT in turn, over five commands
python -m benchmarks.kills --count 10   fewer
python -m benchmarks.kills --only sweep respond   some of fit, alarms, sweep, respond, export
python -m benchmarks.kills --signal SIGINT        by one signal alone

Each trial begins with earlier results of the same kind in place, or with none. After the kill every file must be the
earlier one, the new one, or part of a folder that is marked unfinished and loads; then the command is run again to its
end, and all of its files must be those of an undisturbed run: to the byte, but for videos. Where a SIGINT comes when
all is written, the exit status is 0, and all files must be there; a command that goes on for longer than a moment after
it has lost it.
"""

import argparse
import contextlib
import json
import os
import random
import shutil
import signal
import tempfile
import time
import warnings
from collections.abc import Mapping
from pathlib import Path

import av
import xarray
from av.error import FFmpegError
from tqdm import tqdm

import lgmd2jax as lgmd
from benchmarks._commands import Command, Runner, commands

Files = Mapping[str, bytes]
_MOMENT = 1.0  # s, which a process may take to end


def files_of(folder: Path) -> dict[str, bytes]:
    """The content of all files by name, hidden ones left out.

    Of fit.json all counts but when and how fast, of a video the time stamps of the frames that can be decoded: on a
    busy machine the encoder's threads make other bytes of the same pictures.
    """
    files = {}
    for path in sorted(folder.rglob("*")):
        name = path.relative_to(folder).as_posix()
        if path.is_file() and not any(part.startswith(".") for part in name.split("/")):
            files[name] = path.read_bytes()
            if path.name == "fit.json":
                files[name] = json.dumps({**json.loads(files[name]), "made": None}).encode()
            if path.suffix == ".mp4":
                with contextlib.suppress(FFmpegError), av.open(str(path)) as container:
                    files[name] = repr([frame.pts for frame in container.decode(video=0)]).encode()
    return files


def faults_of_kill(files: Files, folder: Path, earlier: Files, whole: Files) -> list[str]:
    """What is wrong with the files that a kill left. `earlier`, `whole`: those of before, and of an undisturbed run."""
    if "results/sweep.zarr/zarr.json" in files:
        with xarray.open_zarr(folder / "results/sweep.zarr", chunks=None, consolidated=False) as store:
            store.load()
        return []
    if "results/fit.json" not in files or files == earlier:
        return [
            f"{name} is neither old nor new"
            for name in files
            if files[name] not in (earlier.get(name), whole.get(name))
        ]
    unfinished = json.loads(files["results/fit.json"])["unfinished"]
    if "the search" in unfinished:
        faults = ["finished results were replaced by a search that was stopped"] if earlier else []
    else:
        tables = ("results/model.json", "results/curves.csv", "results/clips.csv")
        faults = [f"{name} is another one" for name in tables if files.get(name) != whole.get(name)]
        faults += [] if unfinished or files == whole else ["it is not whole, and not marked"]
    lgmd.load(folder / "results/model.json")
    if "results/curves.csv" in files:
        lgmd.load_fit(folder / "results")
    return faults


class Study:
    """The trials of one command: an undisturbed run, earlier results, then kills."""

    def __init__(self, command: Command, place: Path, runner: Runner):
        self.command, self.runner, self._place = command, runner, place / command.name.replace(" ", "-")
        self._log = self._place / "log.txt"
        (self._place / "whole").mkdir(parents=True)
        (self._place / "earlier").mkdir()
        self._done(command.at(self._place / "whole"))  # compiles, for those that follow
        shutil.rmtree(self._place / "whole")
        (self._place / "whole").mkdir()
        self._seconds = self._done(command.at(self._place / "whole"))
        if (arguments := command.earlier_at(self._place / "earlier")) is not None:
            self._done(arguments)
        self._whole, self._earlier = files_of(self._place / "whole"), files_of(self._place / "earlier")

    def trial(self, number: int, kind: signal.Signals, share: float) -> tuple[str, list[str]]:
        """Kill the command after a share of its usual time: when that was, in words, and all that is wrong."""
        folder, with_earlier = self._place / f"{number}", bool(self._earlier) and number % 2 == 0
        if with_earlier:
            shutil.copytree(self._place / "earlier", folder)
        else:
            folder.mkdir()
        process = self.runner.start(self.command.at(folder), self._log)
        while process.is_alive() and not self._log.is_file():
            time.sleep(0.001)
        process.join(share * self._seconds)
        pid = process.pid if process.is_alive() else None
        if pid is not None:
            os.kill(pid, kind)
        pressed_at = time.monotonic()
        process.join()
        after = time.monotonic() - pressed_at
        pressed = kind.name if pid else "ended"
        what = f"{self.command.name:14} {pressed:8} at {share:4.0%}, exit status {process.exitcode:4}"
        faults = []
        if pid is not None and process.exitcode == 0:
            what += f" {after:.2f} s after"
            faults += [f"the signal was lost: it went on for {after:.1f} s"] if after > _MOMENT else []
        if process.exitcode not in (0, 130, -signal.SIGKILL):
            faults.append(f"exit status {process.exitcode}: {self._log.read_text()[-300:]!r}")
        files, earlier = files_of(folder), self._earlier if with_earlier else {}
        if pid is not None and process.exitcode == 0 and files != self._whole:
            faults.append("exit status 0, but not all is written")
        faults += faults_of_kill(files, folder, earlier, self._whole)
        unfinished = json.loads(files.get("results/fit.json", b'{"unfinished": []}'))["unfinished"]
        what += f", {len(files)} files" + (f", {len(unfinished)} parts unfinished" if unfinished else "")
        status, _ = self.runner.run(self.command.resumed_at(folder), self._log)
        again = files_of(folder)
        if status or again != self._whole:
            names = [name for name in {**again, **self._whole} if again.get(name) != self._whole.get(name)]
            faults.append(f"gone on with, status {status}, other files: {', '.join(names)}")
        if not faults:
            shutil.rmtree(folder)
        return what, faults

    def _done(self, arguments) -> float:
        status, seconds = self.runner.run(arguments, self._log)
        if status:
            raise RuntimeError(f"{' '.join(arguments)} ended with {status}: {self._log.read_text()[-500:]}")
        return seconds


def main() -> None:
    """Run the study and print a line for each kill."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--count", type=int, default=60)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--signal", choices=("SIGINT", "SIGKILL"), help="only this one")
    parser.add_argument("--only", nargs="+", default=["fit", "alarms", "sweep", "respond", "export"])
    options = parser.parse_args()
    warnings.simplefilter("ignore")  # of unfinished fits
    chance, bad = random.Random(options.seed), 0
    with tempfile.TemporaryDirectory(prefix="kills-") as name:
        place = Path(name)
        os.environ |= {"JAX_COMPILATION_CACHE_DIR": str(place / "compiled"), "JAX_PLATFORMS": "cpu"}
        os.environ |= {"JAX_PERSISTENT_CACHE_MIN_COMPILE_TIME_SECS": "0", "XDG_CACHE_HOME": str(place / "cache")}
        runner = Runner()
        chosen = [command for command in commands(place) if command.name in options.only]
        studies = [Study(command, place, runner) for command in tqdm(chosen, "undisturbed", disable=None)]
        for number in range(options.count):
            study = studies[number % len(studies)]
            kind = signal.SIGKILL if number // len(studies) % 2 else signal.SIGINT
            kind = signal.Signals[options.signal] if options.signal else kind
            what, faults = study.trial(number, kind, chance.uniform(0.05, 1.0))
            bad += bool(faults)
            print(f"{number + 1:3} {what}: {'; '.join(faults) or 'whole, and goes on to the same'}", flush=True)
    print(f"{options.count} kills, {bad} with faults")
    raise SystemExit(bool(bad))


if __name__ == "__main__":
    main()
