"""How long the recorded clips beside this project take to decode; with --labels, their labels in one file.

python -m benchmarks.real_clips                      decode them, with an empty cache, and print for how long
python -m benchmarks.real_clips --labels real.toml   write their labels, with the source of each clip, for
lgmd2jax watch real.toml --model video --baselines   and `lgmd2jax fit video --clips real.toml`

The clips lie in `LGMD2JAX_DATA`, else in ../shared/data, and are no part of the project.
"""

import argparse
import os
import re
import sys
import tempfile
import time
from pathlib import Path

from lgmd2jax.alarms import load_labels

# Frames of the file; what is in no list is not judged.
OLDER = """
[[clip]]
file = "c29.mp4"  # fuqinbing/LGMD-Plus-and-GAs-Open-Source;
drop_duplicates = true
alarm = [[149, 175]]
silent = [[10, 114]]
contact = 174

[[clip]]
file = "tc22.mp4"  # fuqinbing/pLGMD;
alarm = [[45, 60]]
silent = [[64, 119]]
contact = 59

[[clip]]
file = "c21.mp4"  # fuqinbing/LGMD-Plus-and-GAs-Open-Source;
alarm = [[195, 216]]
silent = [[10, 154]]
contact = 214

[[clip]]
file = "nc03.mp4"  # fuqinbing/LGMD-Plus-and-GAs-Open-Source;
drop_duplicates = true
silent = [[95, 150]]

[[clip]]
file = "nc07.mp4"  # fuqinbing/LGMD-Plus-and-GAs-Open-Source;
silent = [[100, 280]]

[[clip]]
file = "cup.mp4"  # opencv-doc;

[[clip]]
file = "tc16.mp4"  # fuqinbing/pLGMD;
crop = ":,36:397"
drop_duplicates = true
silent = []
"""
_FILE = re.compile(r'^file = "(?P<name>[^"]+)"  # (?P<source>[^;]+);.*$', re.MULTILINE)


def main() -> None:
    """Write the labels, or decode all clips and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--labels", type=Path, metavar="FILE", help="write the labels of all clips to this file")
    path = parser.parse_args().labels
    if path is not None:
        path.write_text(labels(), encoding="utf-8")
        return
    with tempfile.TemporaryDirectory() as folder:
        os.environ["XDG_CACHE_HOME"] = folder
        (place := Path(folder) / "real.toml").write_text(labels(), encoding="utf-8")
        wall, processor = time.perf_counter(), time.process_time()
        clips = load_labels(place).load()
        wall, processor = time.perf_counter() - wall, time.process_time() - processor
    frames = sum(int(clip.index[-1]) + 1 for clip in clips)
    print(f"{len(clips)} clips, {frames} frames: {wall:.1f} s, {processor:.1f} s of processor time")


def labels() -> str:
    """The labels of both folders with the places of the clips and their sources, which comments name there."""
    data = Path(os.environ.get("LGMD2JAX_DATA") or Path(__file__).resolve().parents[2] / "shared" / "data")
    if not data.is_dir():
        sys.exit(f"no recordings at {data}; set LGMD2JAX_DATA to the folder that holds them")
    newer = (data / "real_clips" / "labels.toml").read_text(encoding="utf-8")
    texts = {data / "real_clips": newer, data / "clips": OLDER}
    return "\n".join(
        _FILE.sub(rf'file = "{folder.as_posix()}/\g<name>"\nsource = "\g<source>"', text)
        for folder, text in texts.items()
    )


if __name__ == "__main__":
    main()
