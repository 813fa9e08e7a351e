"""Formulas as MathML: no script, no font, no network."""

import re

import latex2mathml.converter

#: What browsers need to show the MathML as LaTeX would.
REPAIRS = (
    # The bold digit itself: browsers do not know mathvariant.
    (r'<mn mathvariant="bold">1</mn>', "<mn>&#x1D7CF;</mn>"),
    # det, Div, Grad: names, with a thin space before what they act on, not operators with space around.
    (r"<mo[^>]*>([A-Za-z]{2,})</mo>(?=<m(i|sub|sup|row|frac))", r'<mi>\1</mi><mspace width="0.167em"/>'),
    (r"<mo[^>]*>([A-Za-z]{2,})</mo>", r"<mi>\1</mi>"),
    # Bars of a magnitude without space around.
    (r"<mo[^>]*>&#x0007C;</mo>", '<mo lspace="0" rspace="0" stretchy="false">|</mo>'),
    # A slash without space around, and a minus sign that is not between two terms.
    (r"<mo>&#x0002F;</mo>", '<mo lspace="0" rspace="0">/</mo>'),
    (
        r"(<mo>(?:&#x0003D;|&#x02265;|&#x02264;)</mo>)<mo>&#x02212;</mo>",
        r'\1<mo form="prefix">&#x02212;</mo>',
    ),
    # A prime is raised by itself.
    (
        r"<msup>(<mi>[^<]+</mi>)<mi>&#x02032;</mi></msup>",
        r'<mrow>\1<mo lspace="0" rspace="0">&#x2032;</mo></mrow>',
    ),
)


def mathml(latex: str, *, display: bool = False) -> str:
    """A formula as MathML."""
    made = latex2mathml.converter.convert(latex, display="block" if display else "inline")
    for pattern, repaired in REPAIRS:
        made = re.sub(pattern, repaired, made)
    return made
