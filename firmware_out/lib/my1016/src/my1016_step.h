// The recursion of each kind of component in fixed point: what one sample does to a state.
//
// x1 is the temperature rise, x2.. its increments over one sample (staggered by half a sample where that saves work).
// q = -R[n-1] (xn + R[n-2] (x[n-1] + .. + R[0] (x1 - S))) drives them; S is the steady rise and R the nested rates of
// the present PWM, from my1016_schedule().
#ifndef MY1016_STEP_H
#define MY1016_STEP_H

#include "my1016_word.h"

#ifdef __AVR__

// Everything that cannot saturate, in assembly: registers are saved once for the whole sample, and the time that it
// takes does not depend on the compiler's options. The C++ below does the same for every other machine.
//
// task 0: one sample of all of it; state and rates point to a[0]. The result means nothing.
// task 1: the result is my1016_A_drive() of the one state at `state`, which does not change.
//
// Registers: Z state, Y rates, d r22..r25 times a r18..r21 (see my1016_word.h), r10 components left, r9 runs left.
static inline MY1016_ONE_COPY int32_t my1016_run(void *state, const void *rates, uint8_t task) {
    register uint8_t task_ __asm__("r20") = task;
    register int32_t result __asm__("r22");
    __asm__ volatile(
        // Y: coefficients; T: whether to leave after q.
        "push r28\n\tpush r29\n\tmovw r28, r26\n\t"
        "bst r20, 0\n\tbrtc 1f\n\trjmp 6f\n\t1:\n\t"
        // ---- brush ----
        ".LqA%=:\n\t"
        // d = x1.hi - S
        "ldd r22, Z+2\n\tldd r23, Z+3\n\tldd r24, Z+4\n\tldd r25, Z+5\n\tldd r0, Y+12+0\n\tsub r22, r0\n\t"
        "ldd r0, Y+12+1\n\tsbc r23, r0\n\tldd r0, Y+12+2\n\tsbc r24, r0\n\tldd r0, Y+12+3\n\tsbc r25, r0\n\t"
        // a = R0
        "ldd r18, Y+0\n\tldd r19, Y+1\n\tldd r20, Y+2\n\tldd r21, Y+3\n\t"
        // product, from bit 32 on
        "clr r11\n\t"
        MY1016_PRODUCT_3
        // d < 0: less a * 2^32
        "sbrs r25, 7\n\trjmp 1f\n\tsub r16, r18\n\tsbc r17, r19\n\tsbc r15, r20\n\tsbc r13, r21\n\t1:\n\t"
        // d = x2.hi + product + 1 (half of what two roundings down lose)
        "sec\n\tldd r22, Z+8\n\tadc r22, r16\n\tldd r23, Z+9\n\tadc r23, r17\n\tldd r24, Z+10\n\tadc r24, r15\n\t"
        "ldd r25, Z+11\n\tadc r25, r13\n\t"
        // a = R1
        "ldd r18, Y+4\n\tldd r19, Y+5\n\tldd r20, Y+6\n\tldd r21, Y+7\n\t"
        // product, from bit 32 on
        MY1016_PRODUCT_3
        // d < 0: less a * 2^32
        "sbrs r25, 7\n\trjmp 1f\n\tsub r16, r18\n\tsbc r17, r19\n\tsbc r15, r20\n\tsbc r13, r21\n\t1:\n\t"
        // d = x3.hi + product + 1 (half of what two roundings down lose)
        "sec\n\tldd r22, Z+14\n\tadc r22, r16\n\tldd r23, Z+15\n\tadc r23, r17\n\tldd r24, Z+16\n\tadc r24, r15\n\t"
        "ldd r25, Z+17\n\tadc r25, r13\n\t"
        // a = R2
        "ldd r18, Y+8\n\tldd r19, Y+9\n\tldd r20, Y+10\n\tldd r21, Y+11\n\t"
        // product, from bit 24 on
        MY1016_PRODUCT_3
        // d < 0: less a * 2^32
        "sbrs r25, 7\n\trjmp 1f\n\tsub r16, r18\n\tsbc r17, r19\n\tsbc r15, r20\n\tsbc r13, r21\n\tsbc r11, r11\n\t"
        "1:\n\t"
        // T: only q was wanted.
        "brtc 1f\n\trjmp .LtA%=\n\t1:\n\t"
        // x2
        "ldd r20, Z+6\n\tldd r21, Z+7\n\tldd r22, Z+8\n\tldd r23, Z+9\n\tldd r24, Z+10\n\tldd r25, Z+11\n\t"
        // x2 again
        "mov r26, r21\n\tmovw r18, r22\n\tmovw r0, r24\n\t"
        // >> 12
        "asr r1\n\tror r0\n\tror r19\n\tror r18\n\tror r26\n\tasr r1\n\tror r0\n\tror r19\n\tror r18\n\tror r26\n\t"
        "asr r1\n\tror r0\n\tror r19\n\tror r18\n\tror r26\n\tasr r1\n\tror r0\n\tror r19\n\tror r18\n\tror r26\n\t"
        "mov r12, r1\n\tlsl r12\n\tsbc r12, r12\n\t"
        // x1 += x2 >> 12
        "ldd r14, Z+0+0\n\tadd r14, r26\n\tstd Z+0+0, r14\n\tldd r14, Z+0+1\n\tadc r14, r18\n\tstd Z+0+1, r14\n\t"
        "ldd r14, Z+0+2\n\tadc r14, r19\n\tstd Z+0+2, r14\n\tldd r14, Z+0+3\n\tadc r14, r0\n\tstd Z+0+3, r14\n\t"
        "ldd r14, Z+0+4\n\tadc r14, r1\n\tstd Z+0+4, r14\n\tldd r14, Z+0+5\n\tadc r14, r12\n\tstd Z+0+5, r14\n\t"
        // x3 += q
        "ldd r14, Z+12\n\tldd r26, Z+13\n\tldd r18, Z+14\n\tldd r19, Z+15\n\tldd r0, Z+16\n\tldd r1, Z+17\n\t"
        "sub r14, r27\n\tstd Z+12+0, r14\n\tsbc r26, r16\n\tstd Z+12+1, r26\n\tsbc r18, r17\n\tstd Z+12+2, r18\n\t"
        "sbc r19, r15\n\tstd Z+12+3, r19\n\tsbc r0, r13\n\tstd Z+12+4, r0\n\tsbc r1, r11\n\tstd Z+12+5, r1\n\t"
        // >> 10
        "asr r1\n\tror r0\n\tror r19\n\tror r18\n\tror r26\n\tasr r1\n\tror r0\n\tror r19\n\tror r18\n\tror r26\n\t"
        "mov r12, r1\n\tlsl r12\n\tsbc r12, r12\n\t"
        // x2 += x3 >> 10
        "add r20, r26\n\tstd Z+6+0, r20\n\tadc r21, r18\n\tstd Z+6+1, r21\n\tadc r22, r19\n\tstd Z+6+2, r22\n\t"
        "adc r23, r0\n\tstd Z+6+3, r23\n\tadc r24, r1\n\tstd Z+6+4, r24\n\tadc r25, r12\n\tstd Z+6+5, r25\n\t"
        // The next component.
        "adiw r30, 18\n\tadiw r28, 16\n\t"
        // ---- bearing, magnet, casing ----
        // Each component.
        "ldi r18, 3\n\tmov r10, r18\n\t.LcB%=:\n\t"
        // a = R0
        "ld r18, Y+\n\tld r19, Y+\n\tld r20, Y+\n\tld r21, Y+\n\t"
        // d = x1.hi - S
        "ldd r22, Z+2\n\tldd r23, Z+3\n\tldd r24, Z+4\n\tldd r25, Z+5\n\tld r0, Y+\n\tsub r22, r0\n\tld r0, Y+\n\t"
        "sbc r23, r0\n\tld r0, Y+\n\tsbc r24, r0\n\tld r0, Y+\n\tsbc r25, r0\n\t"
        // product, from bit 24 on
        "clr r11\n\t"
        MY1016_PRODUCT_3
        // d < 0: less a * 2^32
        "sbrs r25, 7\n\trjmp 1f\n\tsub r16, r18\n\tsbc r17, r19\n\tsbc r15, r20\n\tsbc r13, r21\n\tsbc r11, r11\n\t"
        "1:\n\t"
        // x1 += q
        "ld r0, Z\n\tsub r0, r27\n\tst Z+, r0\n\tld r0, Z\n\tsbc r0, r16\n\tst Z+, r0\n\tld r0, Z\n\tsbc r0, r17\n\t"
        "st Z+, r0\n\tld r0, Z\n\tsbc r0, r15\n\tst Z+, r0\n\tld r0, Z\n\tsbc r0, r13\n\tst Z+, r0\n\tld r0, Z\n\t"
        "sbc r0, r11\n\tst Z+, r0\n\t"
        "dec r10\n\tbreq 1f\n\trjmp .LcB%=\n\t1:\n\t"
        "rjmp 9f\n\t"
        // ---- q for a change of PWM ----
        // q of the shape that is asked for.
        "6:\n\t"
        "rjmp .LqA%=\n\t"
        // The result.
        ".LtA%=:\n\tmov r22, r16\n\tmov r23, r17\n\tmov r24, r15\n\tmov r25, r13\n\trjmp 9f\n\t"
        // The compiler wants r1 = 0.
        "9:\n\tpop r29\n\tpop r28\n\tclr r1\n\t"
        : "+z"(state), "+x"(rates), "+r"(task_), "=r"(result)
        :
        : "r0", "r1", "r10", "r11", "r12", "r13", "r14", "r15", "r16", "r17", "r18", "r19", "r21", "memory");
    return result;
}

#endif
// ---- brush: order 3 ----
//
// brush, proven for every sequence of PWM: rise within -61..161 K,
//   |x2| at most 1.5e-02 K,
//   |x3| at most 1.1e-05 K,
//   and the rise never more than 9.1e-06 K from the exact solution.

struct my1016_A_Rates {
    uint32_t rate[3];  // R0 * 2^44, R1 * 2^42, R2 * 2^40
    int32_t steady;  // S in 2^-23 K, rounded down
};

struct my1016_A_State {
    my1016_Word x[3];  // x1 in 2^-39 K, x2 in 2^-51 K, x3 in 2^-61 K
};

#ifdef __AVR__

static inline int32_t my1016_A_drive(my1016_A_State *state, const my1016_A_Rates *now) {
    return my1016_run(state, now, 1);
}

#else

// q in 2^-61 K. Every intermediate is proven to fit its 32 bits.
static inline my1016_Word my1016_A_increment(const my1016_A_State *state, const my1016_A_Rates *now) {
    int32_t inner = state->x[0].hi - now->steady;
    // Both parts were rounded down: one unit in the middle of what is lost.
    inner = state->x[1].hi + my1016_high32(inner, now->rate[0]) + 1;
    // Both parts were rounded down: one unit in the middle of what is lost.
    inner = state->x[2].hi + my1016_high32(inner, now->rate[1]) + 1;
    my1016_Word q = {0, 0};
    my1016_subtract24(q, inner, now->rate[2]);
    return q;
}

// -q in 2^-53 K, for a change of PWM.
static inline int32_t my1016_A_drive(const my1016_A_State *state, const my1016_A_Rates *now) {
    my1016_Word q = my1016_A_increment(state, now);
    return (int32_t)(-my1016_whole(q) >> 8);
}

static inline void my1016_A_advance(my1016_A_State *state, const my1016_A_Rates *now) {
    const my1016_Word q = my1016_A_increment(state, now);
    my1016_add(state->x[0], my1016_right12(state->x[1]));
    my1016_add(state->x[2], q);
    my1016_add(state->x[1], my1016_right10(state->x[2]));
}

#endif

// x2 holds 1/12 of q (the trapezoidal rule's error): hand it over from one PWM's q to the next one's.
static inline void my1016_A_carry(my1016_A_State *state, int32_t before, int32_t after) {
    my1016_carry(&state->x[1], (before - after) >> 2, 0);  // both are -q
}

// Rise in thousandths of a kelvin, rounded down.
static inline int32_t my1016_A_rise_mK(const my1016_A_State *state) {
    const int32_t high = state->x[0].hi;
    const uint32_t fraction = ((uint32_t)high & 8388607UL) >> 7;  // in 2^-16 K
    return (high >> 23) * 1000 + (int32_t)((fraction * 1000u) >> 16);
}

// ---- bearing, magnet, casing: order 1 ----
//
// bearing, proven for every sequence of PWM: rise within -60..160 K,
//   and the rise never more than 3.7e-06 K from the exact solution.
// magnet, proven for every sequence of PWM: rise within -60..160 K,
//   and the rise never more than 1.9e-06 K from the exact solution.
// casing, proven for every sequence of PWM: rise within -60..160 K,
//   and the rise never more than 1.8e-06 K from the exact solution.

struct my1016_B_Rates {
    uint32_t rate[1];  // R0 * 2^40
    int32_t steady;  // S in 2^-23 K, rounded down
};

struct my1016_B_State {
    my1016_Word x[1];  // x1 in 2^-39 K
};

#ifdef __AVR__
#else

// q in 2^-39 K. Every intermediate is proven to fit its 32 bits.
static inline my1016_Word my1016_B_increment(const my1016_B_State *state, const my1016_B_Rates *now) {
    int32_t inner = state->x[0].hi - now->steady;
    my1016_Word q = {0, 0};
    my1016_subtract24(q, inner, now->rate[0]);
    return q;
}

static inline void my1016_B_advance(my1016_B_State *state, const my1016_B_Rates *now) {
    my1016_add(state->x[0], my1016_B_increment(state, now));
}

#endif

// Rise in thousandths of a kelvin, rounded down.
static inline int32_t my1016_B_rise_mK(const my1016_B_State *state) {
    const int32_t high = state->x[0].hi;
    const uint32_t fraction = ((uint32_t)high & 8388607UL) >> 7;  // in 2^-16 K
    return (high >> 23) * 1000 + (int32_t)((fraction * 1000u) >> 16);
}

#endif
