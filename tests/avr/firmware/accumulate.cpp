// A running sum: shows that the firmware's state lives on between records and calls.
#include "mailbox.h"
#include <stdint.h>

struct Input {
    uint8_t weight;
    int32_t value;
};

Input gen_input;
int32_t gen_output;

int main() {
    int32_t sum = 0;
    for (;;) {
        GEN_MAILBOX_NEXT();
        sum += gen_input.value * gen_input.weight;
        gen_output = sum;
        GEN_MAILBOX_DONE();
    }
}
