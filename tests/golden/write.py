"""Golden outputs, computed and written: `python -m tests.golden.write`, when numbers are meant to change."""

import time

import numpy as np

import tests.conftest  # noqa: F401 - first, since it sets up XLA and JAX as they are for the tests
from tests.golden import cases


def main() -> None:
    """Compute all cases and write them, by case and name, as one compressed file."""
    for path in cases.keep_files():
        print(f"wrote {path.relative_to(cases.FOLDER)}")
    kept = {}
    for name, compute in cases.CASES.items():
        began = time.monotonic()
        found = compute()
        kept |= {f"{name}|{key}": it for key, it in found.items()}
        print(f"{name}: {len(found)} arrays, {time.monotonic() - began:.1f} s")
    np.savez_compressed(cases.OUTPUTS, allow_pickle=False, **kept)
    print(f"wrote {cases.OUTPUTS.name}: {cases.OUTPUTS.stat().st_size / 1e6:.2f} MB")


if __name__ == "__main__":
    main()
