"""How a state lies in RAM, and the smallest functions of it that have one known text each."""

from __future__ import annotations

import re
from dataclasses import dataclass

from gen.certificate.refuted import Refuted
from gen.certificate.source import Project, spaced

_STRUCTS = {
    "Accumulator": (8, "struct N_Accumulator { uint8_t lo; int32_t hi; };"),
    "Temperature": (16, "struct N_Temperature { uint16_t lo; int32_t hi; };"),
}
_TEXTS = {
    "add": (
        "void N_add(N_Accumulator *sum, float value, uint8_t shift) { "
        "const float scale = 256.0f / static_cast<float>(UINT64_C(1) << shift); "
        "const int64_t whole = static_cast<int64_t>(sum->hi) * 256 + sum->lo + static_cast<int64_t>(value * scale); "
        "sum->lo = static_cast<uint8_t>(whole & 0xFF); sum->hi = static_cast<int32_t>(whole >> 8); }"
    ),
    "take_up": (
        "void N_take_up(N_Temperature *T, int64_t sum, int bits) { "
        "const int64_t whole = (int64_t)T->hi * 65536 + T->lo + N_shifted(sum, bits); "
        "T->lo = (uint16_t)(whole & 0xFFFF); T->hi = (int32_t)(whole >> 16); }"
    ),
    "gather": "void N_gather(uint32_t *&next, const uint32_t *flash) { *next++ = *flash; }",
    "product": (
        "int64_t N_product(int64_t d, uint32_t a, uint8_t least, bool cut) { int64_t left_out = 0; "
        "for (uint8_t i = 0; i < 4; ++i) { for (uint8_t j = 0; i + j <= least && j < 4; ++j) { "
        "const int64_t both = ((d >> (8 * i)) & 0xFF) * (int64_t)((a >> (8 * j)) & 0xFF); "
        "left_out += (i + j < least ? both : cut ? both & 0xFF : 0) * (INT64_C(1) << (8 * (i + j))); } } "
        "return (d * (int64_t)a - left_out) >> (8 * (least + (cut ? 1 : 0))); }"
    ),
}


@dataclass(frozen=True)
class Layout:
    """The states' words in RAM.

    Attributes
    ----------
    kind
        ``int64_t``, of which the upper 32 bits are read, or the name of a structure of ``lo`` and ``hi``.
    low_bits
        Bits below what is read.
    within
        What stands between ``NAME_model.`` and ``T``.
    """

    kind: str
    low_bits: int
    within: str

    @classmethod
    def of(cls, project: Project) -> Layout:
        """Read it from ``NAME_model.h``.

        Raises
        ------
        Refuted
            If it is none that the proof knows.
        """
        model, text = project.model, project.text("_model.h")
        kinds = re.findall(rf"\b(\w+) T\[{model}_STATES\];", text)
        if len(kinds) != 1:
            raise Refuted("the states do not lie in one array")
        within = "state." if re.search(rf"\b{model}_State state;", text) else ""
        if kinds[0] == "int64_t":
            return cls("int64_t", 32, within)
        kind = kinds[0].removeprefix(f"{model}_")
        low_bits, struct = _STRUCTS.get(kind, (0, ""))
        headers = " ".join(
            spaced(project.text(path.name.removeprefix(model))) for path in sorted(project.sources.glob(f"{model}*.h"))
        )
        if not low_bits or headers.count(struct.replace("N_", f"{model}_")) != 1:
            raise Refuted(f"a state's word is none that the proof knows: {kinds[0]}")
        return cls(kind, low_bits, within)


def check_text(model: str, name: str, found: list[str]) -> None:
    """Make sure that a function whose meaning is known has its one text.

    Raises
    ------
    Refuted
        If it has another one.
    """
    expected = _TEXTS[name].replace("N_", f"{model}_")
    of_words = re.compile(rf"\b{model}_(?:{'|'.join(_STRUCTS)}) \*")
    own = [text for text in found if bool(of_words.search(text)) == bool(of_words.search(expected))]
    if [text.removeprefix("static inline ") for text in own] != [expected]:
        raise Refuted(f"{model}_{name} is not the function that the proof knows")
