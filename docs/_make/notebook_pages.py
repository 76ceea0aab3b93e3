"""Executed notebooks as pages: their text and code, what they printed, and their figures as files."""

import nbformat
from nbconvert import MarkdownExporter


def page_of(path, folder: str) -> tuple[str, dict[str, bytes]]:
    """The Markdown of a notebook, and its figures by their paths in the site.

    **Arguments:** `folder`: of the page in the site, to which the notebook's name is added for the figures.
    """
    text, resources = MarkdownExporter().from_notebook_node(nbformat.read(path, as_version=4))
    text, figures = text.replace("](../docs/", "](../"), {}  # from the place of the notebook to that of its page
    for name, content in resources["outputs"].items():
        text = text.replace(f"]({name})", f"]({path.stem}/{name})")
        figures[f"{folder}/{path.stem}/{name}"] = content
    return text, figures
