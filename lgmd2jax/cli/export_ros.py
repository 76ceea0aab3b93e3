"""`lgmd2jax export MODEL --ros DIR`: a ROS 2 package around the model."""

import argparse

from lgmd2jax._files.folder import check_folder, replaced_folder
from lgmd2jax._handover.model_file import as_lgmd2, save
from lgmd2jax._handover.named import model_file, model_named
from lgmd2jax._ros.source import MODEL_FILE, PROGRAM, sources


def export_ros(options: argparse.Namespace) -> None:
    """Check the model, write the package, whole or not at all, and say how to build it.

    **Raises:** `ValueError` for another network, and for a folder of something else.
    """
    folder = options.ros
    if folder.exists() or folder.absolute().parent.is_dir():
        check_folder(folder, PROGRAM)
    model, path = as_lgmd2(model_named(options.model)), model_file(options.model)
    original = None if path is None else path.read_bytes()
    files = sources(model.eye)
    folder.absolute().parent.mkdir(parents=True, exist_ok=True)
    with replaced_folder(folder, PROGRAM, {name.partition("/")[0] for name in files}) as new:
        for name, text in files.items():
            (new / name).parent.mkdir(exist_ok=True)
            (new / name).write_text(text, encoding="utf-8")
        if original is None:
            save(model, new / MODEL_FILE)
        else:
            (new / MODEL_FILE).write_bytes(original)
    print(f"wrote {folder}: a ROS 2 package, not run on hardware; in a workspace:")
    print("  colcon build --packages-select lgmd2")
    print("  ros2 run lgmd2 node --ros-args -r image_raw:=/camera/image_raw   # then: ros2 topic echo /lgmd2/state")
