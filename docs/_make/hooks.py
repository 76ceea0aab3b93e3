"""What MkDocs does besides its plugins: pages made from notebooks, schemas and argparse, and formulas as MathML."""

import html
import os.path
import re
from pathlib import Path

from latex2mathml.converter import convert
from mkdocs.exceptions import PluginError
from mkdocs.structure.files import File, Files

from docs._make.command_page import command_page
from docs._make.notebook_pages import page_of
from docs._make.privacy import loads_from_elsewhere
from docs._make.property_tables import property_tables
from docs._make.schema_pages import schema_page

_ROOT = Path(__file__).parents[2]
_LINK = re.compile(r"\]\(([^):#\s]+)")
_FORMULA = re.compile(r'<(span|div) class="arithmatex">\\[(\[](.*?)\\[)\]]</\1>', re.S)


def on_files(files: Files, config) -> Files:
    """Adds the pages that are made, and the files of the repository that pages show or link."""

    def add(path, **source):
        files.append(file := File.generated(config, path, **source))
        return file

    add("command_line.md", content=command_page())
    for path in sorted((_ROOT / "docs" / "files").glob("*.md")):
        page = files.get_file_from_path(f"files/{path.name}")
        name = re.search(r"<!-- keys of (\w+)\.json -->", page.content_string)
        if name:
            page.content_string = schema_page(name[1], page.content_string)
    properties = files.get_file_from_path("model/properties.md")
    properties.content_string = f"{properties.content_string}\n{property_tables()}"
    for path in sorted((_ROOT / "notebooks").glob("*.ipynb")):
        text, figures = page_of(path, "notebooks")
        add(f"notebooks/{path.stem}.md", content=text)
        for figure, content in figures.items():
            add(figure, content=content)
    pages = list(files.documentation_pages())
    while pages:
        page = pages.pop()
        for link in _LINK.findall(page.content_string):
            path = os.path.normpath(os.path.join(os.path.dirname(page.src_uri), link))
            if files.get_file_from_path(path) is None and (_ROOT / path).is_file():
                file = add(path, abs_src_path=str(_ROOT / path))
                pages += [file] if file.is_documentation_page() else []
    return files


def on_page_content(content: str, **_) -> str:
    """Formulas in the page as MathML, which browsers draw without a script."""

    def formula(match):
        return convert(html.unescape(match[2]), display="block" if match[1] == "div" else "inline")

    return _FORMULA.sub(formula, content)


def on_post_page(output: str, page, **_) -> None:
    """Refuses a page that loads scripts, styles, fonts or pictures from elsewhere."""
    if found := loads_from_elsewhere(output):
        raise PluginError(f"{page.file.src_uri} loads from elsewhere: {', '.join(found)}")
