"""Formulas of the report, which its text has in plain letters, as MathML: every browser sets it by itself.

A formula is found by its symbols, "kappa_d/kappa_inf = alpha (1-2nu)/(1-nu)^2 d/a_r" for instance, by an error after
+-, or by a power of ten. A blank multiplies, and / binds more tightly than a blank.
"""

import re
from html import escape
from typing import NamedTuple

_LETTERS = {"kappa": "\u03ba", "alpha": "\u03b1", "nu": "\u03bd", "pi": "\u03c0", "inf": "\u221e"}
_SYMBOLS = ("kappa_inf", "kappa_d", "kappa", "alpha", "a_r", "g_c", "E*", "nu", "pi")
_RELATIONS = {"=": "=", "<": "<", ">": ">", "+-": "\u00b1"}
_SIGNS = {"+": "+", "-": "\u2212"}

_TOKEN = re.compile(
    r"(?P<number>(?<![\w.])\d+(?:\.\d+)?(?:e[+-]?\d+)?(?=\W|$|nu\b|pi\b))"
    rf"|(?P<symbol>(?<![A-Za-z_])(?:{'|'.join(map(re.escape, _SYMBOLS))})(?!\w)|(?<!\w)[dLnHpMy](?!\w))"
    r"|(?P<root>\bsqrt(?=\())"
    r"|(?P<sign>\+-|[-+=<>/^()])"
)


class _Token(NamedTuple):
    kind: str
    text: str
    start: int
    end: int


def typeset(text: str) -> str:
    """HTML of a text: formulas in MathML, with the plain letters as `alttext`, and the rest as it is."""
    shown, done = "", 0
    for start, end in _formulas(text):
        plain = text[start:end]
        mathml = _Formula(_tokens(plain)).relation()
        shown += _words(text[done:start])
        shown += f'<math displaystyle="true" alttext="{escape(plain)}"><mrow>{mathml}</mrow></math>'
        done = end
    return shown + _words(text[done:])


def _words(text: str) -> str:
    return escape(text, quote=False).replace("+-", _RELATIONS["+-"])


def _tokens(text: str) -> list[_Token]:
    return [_Token(m.lastgroup or "", m[0], m.start(), m.end()) for m in _TOKEN.finditer(text)]


def _formulas(text: str) -> list[tuple[int, int]]:
    """Where the formulas of a text begin and end."""
    found: list[tuple[int, int]] = []
    run: list[_Token] = []
    for token in [*_tokens(text), None]:
        if token and run and text[run[-1].end : token.start] in ("", " "):
            run.append(token)
            continue
        found += _whole(text, run)
        run = [token] if token else []
    return found


def _whole(text: str, run: list[_Token]) -> list[tuple[int, int]]:
    """The formula in a run of tokens: its longest parts that can be read as one."""
    found = []
    start = 0
    while start < len(run):
        for end in range(len(run), start, -1):
            part = run[start:end]
            if _is_formula(part, text):
                found.append((part[0].start, part[-1].end))
                start = end
                break
        else:
            start += 1
    return found


def _is_formula(part: list[_Token], text: str) -> bool:
    """Whether tokens are one formula, and more than a number or a pair of brackets around a word."""
    worth = any(t.kind in ("symbol", "root") or t.text in ("+-", "^") or "e" in t.text for t in part)
    alone = part[0].text not in _SIGNS or part[0].start == 0 or text[part[0].start - 1] == " "
    if not worth or not alone:
        return False
    formula = _Formula(part)
    try:
        formula.relation()
    except (IndexError, ValueError):
        return False
    return formula.place == len(part)


class _Formula:
    """Reads the tokens of a formula; each method reads one part from where the last one ended, and gives its MathML."""

    def __init__(self, tokens: list[_Token]) -> None:
        self.tokens = tokens
        self.place = 0

    def next(self) -> str:
        """The text of the next token; empty at the end."""
        return self.tokens[self.place].text if self.place < len(self.tokens) else ""

    def take(self, text: str) -> None:
        """Go on behind a token. Raises `ValueError` for another one."""
        if self.next() != text:
            raise ValueError(f"{self.next()!r} instead of {text!r}")
        self.place += 1

    def relation(self) -> str:
        """Sums, equal or not."""
        parts = [self.sum()]
        while self.next() in _RELATIONS:
            relation = self.next()
            self.take(relation)
            parts += [f"<mo>{escape(_RELATIONS[relation])}</mo>", self.sum()]
        return "".join(parts)

    def sum(self) -> str:
        """Products, added or taken away."""
        parts = [] if self.next() in _SIGNS else [self.product()]
        while self.next() in _SIGNS:
            sign = self.next()
            self.take(sign)
            parts += [f"<mo>{_SIGNS[sign]}</mo>", self.product()]
        return "".join(parts)

    def product(self) -> str:
        """Fractions side by side."""
        parts = [self.fraction()]
        while self.place < len(self.tokens) and (self.next() == "(" or self.tokens[self.place].kind != "sign"):
            parts.append(self.fraction())
        return "".join(parts)

    def fraction(self) -> str:
        """Powers over each other; a fraction bar needs no brackets, and a number before its upper part joins it."""
        kinds = [token.kind for token in self.tokens[self.place : self.place + 2]]
        factor = self.atom()[0] if kinds in (["number", "symbol"], ["number", "root"]) else ""
        whole, bare = (factor + part for part in self.power())
        while self.next() == "/":
            self.take("/")
            whole = bare = f"<mfrac><mrow>{bare}</mrow><mrow>{self.power()[1]}</mrow></mfrac>"
        return whole

    def power(self) -> tuple[str, str]:
        """A factor that may have an exponent; and the same without brackets around all of it."""
        whole, bare = self.atom()
        if self.next() != "^":
            return whole, bare
        self.take("^")
        whole = f"<msup><mrow>{whole}</mrow><mrow>{self.atom()[1]}</mrow></msup>"
        return whole, whole

    def atom(self) -> tuple[str, str]:
        """A number, a symbol, a root, or a formula in brackets; and the same without them."""
        token = self.tokens[self.place]
        if token.kind == "sign" and token.text != "(":
            raise ValueError(f"{token.text!r} instead of a value")
        self.place += 1
        if token.kind == "number":
            return (_number(token.text),) * 2
        if token.kind == "symbol":
            return (_symbol(token.text),) * 2
        if token.kind == "root":
            return (f"<msqrt>{self.atom()[1]}</msqrt>",) * 2
        inside = self.relation()
        self.take(")")
        return f"<mrow><mo>(</mo>{inside}<mo>)</mo></mrow>", inside


def _number(text: str) -> str:
    factor, _, power = text.partition("e")
    if not power:
        return f"<mn>{factor}</mn>"
    ten = f"<msup><mn>10</mn><mn>{str(int(power)).replace('-', _SIGNS['-'])}</mn></msup>"
    return ten if factor == "1" else f"<mn>{factor}</mn><mo>\u00d7</mo>{ten}"


def _symbol(text: str) -> str:
    if text == "E*":
        return "<msup><mi>E</mi><mo>*</mo></msup>"
    letter, _, below = text.partition("_")
    shown = f"<mi>{_LETTERS.get(letter, letter)}</mi>"
    return f"<msub>{shown}<mi>{_LETTERS.get(below, below)}</mi></msub>" if below else shown
