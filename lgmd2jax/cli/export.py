"""`lgmd2jax export MODEL --python DIR | --c DIR | --ros DIR`: all that a robot needs, in one folder."""

import argparse
from pathlib import Path

from lgmd2jax import hard
from lgmd2jax._files.atomic import replaced
from lgmd2jax._handover.model_file import as_lgmd2, save
from lgmd2jax._handover.named import model_file, model_named

_ONLY_C = ("rows", "cols", "degrees_per_pixel", "fps", "ram", "protocol", "clip")


def run(options: argparse.Namespace) -> None:
    """Check the model, write the files, and say how to use them."""
    if options.c is not None:
        from lgmd2jax.cli.export_c import export_c

        export_c(options)
        return
    for name in _ONLY_C:
        if getattr(options, name) is not None:
            raise ValueError(f"--{name.replace('_', '-')} belongs to --c; hard.py takes frames of any size")
    if options.ros is not None:
        from lgmd2jax.cli.export_ros import export_ros

        export_ros(options)
        return
    model, folder = as_lgmd2(model_named(options.model)), options.python
    paths = folder / "model.json", folder / "hard.py"
    _check_place(folder, paths)
    source = Path(hard.__file__).read_bytes()
    path = model_file(options.model)
    original = None if path is None else path.read_bytes()
    folder.mkdir(parents=True, exist_ok=True)
    with replaced(paths[0]) as target, replaced(paths[1]) as program:
        program.write_bytes(source)
        if original is None:
            save(model, target)
        else:
            target.write_bytes(original)
    print(f"wrote {paths[0]} and {paths[1]}; there, with NumPy alone:")
    if model.eye is None:
        arguments, meaning = "frame, interval=33.3", "any size, and ms since the last frame"
    else:
        arguments, meaning = "frame", f"{model.eye.rows} x {model.eye.cols} at {model.eye.fps:g} fps"
    print("  import hard")
    print('  model = hard.load("model.json")')
    print(f"  now = model.step({arguments})  # grey levels 0..255, {meaning}; then now.spikes, now.collision")


def _check_place(folder, paths):
    """Refuse to write over what an export did not make: both of its files name the format."""
    if folder.exists() and not folder.is_dir():
        raise ValueError(f"{folder} is not a folder; --python takes one")
    for path in paths:
        if path.is_file() and f'"{hard.FORMAT}"'.encode() not in path.read_bytes():
            raise ValueError(f"{path} is something else, and would be lost; move it away, or give another folder")
