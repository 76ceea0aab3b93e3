"""The 22 response properties with their bounds and evidence, from where the library declares them."""

from lgmd2jax._characterise.properties import ROWS


def property_tables() -> str:
    """A section a property: what is measured, and a table of its lines."""
    parts = []
    for row in ROWS:
        parts += [f"## {row.number}. {row.name}", f"{row.definition} Neuron: {row.neuron}; it holds if {row.holds_if}."]
        lines = [f"| {it.label} | {it.unit} | {it.bound or 'printed only'} | {it.evidence} |" for it in row.lines]
        parts.append("\n".join(["| line | unit | bound | evidence |", "|---|---|---|---|", *lines]))
    return "\n\n".join(parts) + "\n"
