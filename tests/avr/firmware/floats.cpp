// One float32 sum, difference and product a record.
#include "mailbox.h"

struct Pair {
    float a, b;
};
struct Answer {
    float sum, difference, product;
};

Pair gen_input;
Answer gen_output;

int main() {
    for (;;) {
        GEN_MAILBOX_NEXT();
        gen_output.sum = gen_input.a + gen_input.b;
        gen_output.difference = gen_input.a - gen_input.b;
        gen_output.product = gen_input.a * gen_input.b;
        GEN_MAILBOX_DONE();
    }
}
