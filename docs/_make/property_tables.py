"""The 22 response properties with their bounds and evidence, from where the library declares them."""

from lgmd2jax._characterise.properties import ROWS
from lgmd2jax._characterise.row import Line


def property_tables() -> str:
    """A section a property: what is measured, and a table of its criteria."""
    parts = []
    for row in ROWS:
        parts += [f"## {row.number}. {row.name}", f"{row.definition} Neuron: {row.neuron}; it holds if {row.holds_if}."]
        parts.append(
            "\n".join(["| criterion | unit | bound | evidence |", "|---|---|---|---|", *map(_line, row.lines)])
        )
    return "\n\n".join(parts) + "\n"


def _line(line: Line) -> str:
    cells = (line.label, line.unit, line.bound or "printed only", line.evidence if line.judged else "")
    return "| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |"
