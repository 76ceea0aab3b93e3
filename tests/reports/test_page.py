"""The page of a fit: it holds its figures and asks for nothing from elsewhere."""

import base64
import re

from lgmd2jax._reports.page import report_page
from lgmd2jax._reports.section import as_html
from lgmd2jax.fitting import Free, Supplement
from tests.fitting.fits import curve, fit_with
from tests.fitting.test_report import Reader


def test_a_page_holds_report_and_figures_and_nothing_else_is_fetched(tmp_path):
    pictures = {"fit.png": b"\x89PNG one", "diagnostics.png": b"\x89PNG two"}
    for name, content in pictures.items():
        (tmp_path / name).write_bytes(content)
    fit = fit_with(Free(theta2=None), [curve()])
    report = as_html(fit.sections(Supplement(left_out={"loom": 0.91})))
    page = report_page("Fit a < b", [tmp_path / name for name in pictures], report)
    references = Reader(page).references
    assert [base64.b64decode(it.removeprefix("data:image/png;base64,")) for it in references] == [*pictures.values()]
    assert report in page
    assert "<title>Fit a &lt; b</title>" in page
    assert not re.search(r"https?:|@import|url\(|<script|<link|<iframe", page)
    assert str(tmp_path) not in page
