"""Parts of reports: sections as text and HTML, digits, the page."""
