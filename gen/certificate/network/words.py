"""How a state lies in RAM, and the smallest functions of it that have one known text each."""

from __future__ import annotations

import re

from gen.certificate.refuted import Refuted
from gen.certificate.source import Project, spaced

_STRUCTS = {
    "Accumulator": (8, "struct N_Accumulator { uint8_t lo; int32_t hi; };"),
    "Temperature": (16, "struct N_Temperature { uint16_t lo; int32_t hi; };"),
}
_TEXTS = {
    "sum": "N_Sum N_sum(uint16_t start) { return start; }",
    "plus": "N_Sum N_plus(N_Sum sum, int32_t d, uint32_t a) { return sum + N_product(d, a, 2, false); }",
    "down": "int32_t N_down(N_Sum sum, uint8_t bits) { return (int32_t)(sum >> bits); }",
    "scaled": (
        "uint32_t N_scaled(uint32_t word, int32_t factor) "
        "{ return (uint32_t)N_down(N_plus(N_sum(0), factor, word), 14); }"
    ),
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


def low_bits(project: Project) -> int:
    """Bits of a state's ``lo``, below what is read of it; from ``NAME_model.h``.

    Raises
    ------
    Refuted
        If the states' words are none that the proof knows.
    """
    model, text = project.model, project.text("_model.h")
    kinds = re.findall(rf"\b(\w+) T\[{model}_STATES\];", text)
    if len(kinds) != 1 or not re.search(rf"\b{model}_State state;", text):
        raise Refuted("the states do not lie in one array")
    bits, struct = _STRUCTS.get(kinds[0].removeprefix(f"{model}_"), (0, ""))
    headers = " ".join(
        spaced(project.text(path.name.removeprefix(model))) for path in sorted(project.sources.glob(f"{model}*.h"))
    )
    if not bits or headers.count(struct.replace("N_", f"{model}_")) != 1:
        raise Refuted(f"a state's word is none that the proof knows: {kinds[0]}")
    return bits


def check_text(model: str, name: str, found: list[str]) -> None:
    """Make sure that a function whose meaning is known has its one text.

    Raises
    ------
    Refuted
        If it has another one.
    """
    expected = _TEXTS[name].replace("N_", f"{model}_")
    if [text.removeprefix("static inline ") for text in found] != [expected]:
        raise Refuted(f"{model}_{name} is not the function that the proof knows")
