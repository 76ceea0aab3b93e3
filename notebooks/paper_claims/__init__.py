"""What Fu, Hu & Yue (arXiv 1801.06452) say of their LGMD2, in 32 claims, each measured here and nowhere else."""

from IPython.display import Markdown

from notebooks.paper_claims import (
    clips as clips,
    recorded as recorded,
    robot as robot,
    synthetic as synthetic,
    text as text,
)
from notebooks.paper_claims._claim import CLAIMS as CLAIMS, Claim as Claim, Finding as Finding
from notebooks.paper_claims._shown import (
    REST as REST,
    ROBOT_T_SP as ROBOT_T_SP,
    T_SP as T_SP,
    Seen as Seen,
    see as see,
    shown as shown,
)


def told(*numbers: int) -> Markdown:
    """Claims with what was measured and whether they hold, for a cell of a notebook."""
    found = ((CLAIMS[number], CLAIMS[number].measure()) for number in numbers)
    return Markdown(
        "\n\n".join(f"**{it.number}. {it.text}** *{now.measured}.* Holds: **{now.verdict}**." for it, now in found)
    )
