"""What pages may not do: load scripts, styles, fonts or pictures from another host."""

import re

_FROM_ELSEWHERE = re.compile(
    r"""<(?:script|img|iframe|source|video|audio|object|embed)\b[^>]*\b(?:src|data)=["']?(?:https?:)?//[^\s"'>]*"""
    r"""|<link\b(?![^>]*\brel=["']?canonical)[^>]*\bhref=["']?(?:https?:)?//[^\s"'>]*"""
    r"""|(?:@import\s*["']|url\(["']?)(?:https?:)?//[^\s"')]*"""
)


def loads_from_elsewhere(text: str) -> list[str]:
    """What HTML or CSS loads from another host when it is shown; links that a reader follows are none of it."""
    return _FROM_ELSEWHERE.findall(text)
