// Each level of descend() takes 4 bytes of stack: 3 of return address and the register that it saves.
#include "mailbox.h"
#include <stdint.h>

uint8_t gen_input;
uint8_t gen_output;

extern "C" void descend(uint8_t levels);
__asm__(".section .text.descend\n"
        ".global descend\n"
        "descend:\n"
        "\tpush r24\n"
        "\tdec r24\n"
        "\tbreq 1f\n"
        "\tcall descend\n"
        "1:\tpop r24\n"
        "\tret\n"
        ".text\n");

int main() {
    for (;;) {
        GEN_MAILBOX_NEXT();
        descend(gen_input);
        gen_output = gen_input;
        GEN_MAILBOX_DONE();
    }
}
