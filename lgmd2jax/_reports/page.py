"""A fit's report as one HTML page that holds its figures, so that the file can be sent as it is."""

import base64
from collections.abc import Sequence
from html import escape
from pathlib import Path

_STYLE = """
:root { color-scheme: light dark; }
body { font: 15px/1.45 system-ui, sans-serif; max-width: 75rem; margin: 2rem auto; padding: 0 1rem; }
figure { margin: 1.5rem 0; }
img { max-width: 100%; background: white; }
table { font-variant-numeric: tabular-nums; }
"""


def report_page(title: str, figures: Sequence[Path], report: str) -> str:
    """The page: the figures, PNG files, and the report, HTML, below them. It asks for nothing from elsewhere."""
    title = escape(title)
    pictures = "\n".join(
        f'<figure><img alt="{escape(path.stem)} of {title}" src="data:image/png;base64,{_base64(path)}"></figure>'
        for path in figures
    )
    return f"""<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>{title}</title>
<style>{_STYLE}</style>
</head>
<body>
<h1>{title}</h1>
{pictures}
<h2>Report</h2>
{report}
</body>
</html>
"""


def _base64(path: Path) -> str:
    return base64.b64encode(path.read_bytes()).decode("ascii")
