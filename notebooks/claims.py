"""Measure the paper's claims and write the table.

python -m notebooks.claims                    all 32, into notebooks/claims.md
python -m notebooks.claims 17 22 24           only these, printed and not written
"""

import argparse
from collections.abc import Iterator
from pathlib import Path

from tqdm import tqdm

from lgmd2jax._files.atomic import replaced
from notebooks.paper_claims import CLAIMS, Claim
from notebooks.paper_claims.clips import ON_CLIPS, on_clips

TABLE = Path(__file__).with_name("claims.md")
HEAD = """# The claims of the paper, and whether they hold

Fu, Hu & Yue, [arXiv 1801.06452](https://arxiv.org/abs/1801.06452). The LGMD2 has Table I, hard thresholds and 30
frames per second; the LGMD1 is that of Yue & Rind 2006. Synthetic stimuli are those of `stimuli/paper.toml`; what the
paper recorded is replaced by photographs and a camera with noise of two grey levels (`cluttered.toml`, `robot.toml`),
each repeat in other noise and another phase of the camera's clock. Peaks are of the SMP after adaptation, up to the
end of motion. Lines without a number choose otherwise what the paper leaves open. "Fitted parameters" are those of
`fits/lgmd2`, taken to the frame rate and the field of view. "Filmed clips" come from dash cameras and one held in a
hand; they are not in this project, and are seen once each as by `lgmd2jax respond CLIP --resize 108 --drop-duplicates`.
Written by `python -m notebooks.claims`, where LGMD2JAX_DATA names the folder of the clips.
"""


def rows(claim: Claim) -> Iterator[str]:
    """A claim's row of the table, one for each choice that the paper leaves open, and one for clips that film it."""
    found = claim.measure()
    yield f"| {claim.number} | {claim.where} | {claim.text} | {found.measured} | {found.verdict} |"
    for choice, arguments in claim.choices.items():
        other = claim.measure(**arguments)
        yield f"| | | *{choice}* | {other.measured} | {other.verdict} |"
    if claim.number in ON_CLIPS:
        filmed = on_clips(claim.number)
        yield f"| | | *filmed clips* | {filmed.measured} | {filmed.verdict} |"


def table(numbers: list[int]) -> str:
    """The rows of these claims, under headings."""
    parts = {
        "Synthetic stimuli": range(1, 15),
        "Recorded": range(15, 21),
        "Robot": range(21, 26),
        "Text": range(26, 33),
    }
    lines = []
    bar = tqdm(total=len(numbers), unit="claim")
    for part, here in parts.items():
        chosen = [number for number in numbers if number in here]
        if chosen:
            lines += ["", f"## {part}", "", "| | in | claim | measured | holds |", "|---|---|---|---|---|"]
        for number in chosen:
            lines += rows(CLAIMS[number])
            bar.update()
    bar.close()
    return "\n".join(lines) + "\n"


def main() -> None:
    """Measure and write."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("number", nargs="*", type=int, help="of a claim (default: all)")
    options = parser.parse_args()
    if options.number:
        print(table(options.number))
        return
    text = HEAD + table(sorted(CLAIMS))
    print(text)
    with replaced(TABLE) as path:
        path.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
