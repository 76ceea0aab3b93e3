"""What MkDocs does besides its plugins: files of the repository that pages link to, and formulas as MathML."""

import html
import re
from pathlib import Path

from latex2mathml.converter import convert
from mkdocs.structure.files import File

_ROOT = Path(__file__).parents[2]
_OF_REPOSITORY = re.compile(r"\]\((?:\.\./)*((?:fits|stimuli|notebooks)/[^)#\s]+)")
_FORMULA = re.compile(r'<(span|div) class="arithmatex">\\[(\[](.*?)\\[)\]]</\1>', re.S)


def on_files(files, config):
    """Pictures and tables of the repository, at their paths in the site, where a page shows or links them."""
    for page in list(files.documentation_pages()):
        for path in _OF_REPOSITORY.findall(page.content_string):
            if files.get_file_from_path(path) is None:
                files.append(File.generated(config, path, abs_src_path=str(_ROOT / path)))
    return files


def on_page_content(content: str, **_) -> str:
    """Formulas in the page as MathML, which browsers draw without a script."""

    def formula(match):
        return convert(html.unescape(match[2]), display="block" if match[1] == "div" else "inline")

    return _FORMULA.sub(formula, content)
