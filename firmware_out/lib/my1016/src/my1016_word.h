// 48-bit words and the product of a signed by an unsigned 32-bit number, kept from a whole byte on.
//
// A word is hi * 2^16 + lo; lo carries the residue of every addition on to the next sample. The compiler's own
// 64-bit product and shift would cost 280..380 cycles on the AVR; the blocks below take 65..80. On every other machine
// the same numbers come from plain 64-bit arithmetic: what the test on the host and on the emulated board compares.
#ifndef MY1016_WORD_H
#define MY1016_WORD_H

#include <stdint.h>

#include <string.h>

#include "my1016_platform.h"

struct my1016_Word {
    uint16_t lo;
    int32_t hi;
};

#ifdef __AVR__

// Byte products d[i] * a[j] of equal i + j weigh the same; "(i,j)@c" adds one at byte c = i + j of the sum b0..b7.
// d is taken as unsigned here. The order is such that no chain of additions can carry past the byte at which it stops
// (each product is at most 0xFE01).
//
//   a: r18..r21    d: r22..r25 (r22, r23 clobbered)    0: r11
//   b2:b3 r26:r27    b4:b5 r16:r17    b6 r15    b7 r13    scratch r14, r12, r0, r1

// (2,1), (2,3), (1,2) and (2,2), on b3 in r27 and b4:b5.
#define MY1016_MIDDLE                                                                                     \
    /* (2,1)@3: stops at b5 */                                                                                \
    "mul r24, r19\n\t"                                                                                        \
    "add r27, r0\n\t"                                                                                         \
    "adc r16, r1\n\t"                                                                                         \
    "adc r17, r11\n\t"                                                                                        \
    /* (2,3)@5 fresh into r14:b6, with (1,2)@3 */                                                             \
    "mul r24, r21\n\t"                                                                                        \
    "movw r14, r0\n\t"                                                                                        \
    "mul r23, r20\n\t"                                                                                        \
    "add r27, r0\n\t"                                                                                         \
    "adc r16, r1\n\t"                                                                                         \
    "adc r17, r14\n\t"                                                                                        \
    "adc r15, r11\n\t"                                                                                        \
    /* (2,2)@4: stops at b6 */                                                                                \
    "mul r24, r20\n\t"                                                                                        \
    "add r16, r0\n\t"                                                                                         \
    "adc r17, r1\n\t"                                                                                         \
    "adc r15, r11\n\t"

// From byte 2 on, for the variants with the columns 1 and 2: on entry b2:b3 and r12 (for b4) hold the sum so far.
#define MY1016_UPPER                                                                                      \
    /* (1,3)@4 fresh into b4:b5, with (1,1)@2 */                                                              \
    "mul r23, r21\n\t"                                                                                        \
    "movw r16, r0\n\t"                                                                                        \
    "mul r23, r19\n\t"                                                                                        \
    "add r26, r0\n\t"                                                                                         \
    "adc r27, r1\n\t"                                                                                         \
    "adc r16, r12\n\t"                                                                                        \
    "adc r17, r11\n\t"                                                                                        \
    MY1016_MIDDLE

// The products of d3, and the sign.
#define MY1016_TOP                                                                                        \
    /* (3,3)@6 fresh into r12:b7, with (3,1)@4 */                                                             \
    "mul r25, r21\n\t"                                                                                        \
    "movw r12, r0\n\t"                                                                                        \
    "mul r25, r19\n\t"                                                                                        \
    "add r16, r0\n\t"                                                                                         \
    "adc r17, r1\n\t"                                                                                         \
    "adc r15, r12\n\t"                                                                                        \
    "adc r13, r11\n\t"                                                                                        \
    /* (3,2)@5, held in the dead d0:d1, with (3,0)@3 */                                                       \
    "mul r25, r20\n\t"                                                                                        \
    "movw r22, r0\n\t"                                                                                        \
    "mul r25, r18\n\t"                                                                                        \
    "add r27, r0\n\t"                                                                                         \
    "adc r16, r1\n\t"                                                                                         \
    "adc r17, r22\n\t"                                                                                        \
    "adc r15, r23\n\t"                                                                                        \
    "adc r13, r11\n\t"

// Without the columns 0 to 2: 10 byte products.
#define MY1016_PRODUCT_6                                                                                  \
    /* (1,3)@4 fresh into b4:b5; (0,3)@3: at most 0xFEFF there */                                             \
    "mul r23, r21\n\t"                                                                                        \
    "movw r16, r0\n\t"                                                                                        \
    "mul r22, r21\n\t"                                                                                        \
    "mov r27, r0\n\t"                                                                                         \
    "add r16, r1\n\t"                                                                                         \
    "adc r17, r11\n\t"                                                                                        \
    MY1016_MIDDLE MY1016_TOP

// Without (0,0), (0,1) and (1,0): 13 byte products.
#define MY1016_PRODUCT_3                                                                                  \
    /* (0,2)@2 fresh, (2,0)@2: carry into b4 = r12; then at most 0x01FC02 */                                  \
    "mul r22, r20\n\t"                                                                                        \
    "movw r26, r0\n\t"                                                                                        \
    "mul r24, r18\n\t"                                                                                        \
    "add r26, r0\n\t"                                                                                         \
    "adc r27, r1\n\t"                                                                                         \
    "clr r12\n\t"                                                                                             \
    "rol r12\n\t"                                                                                             \
    /* (0,3)@3: at most 0xFFFD02 */                                                                           \
    "mul r22, r21\n\t"                                                                                        \
    "add r27, r0\n\t"                                                                                         \
    "adc r12, r1\n\t"                                                                                         \
    MY1016_UPPER MY1016_TOP

// Without (0,0) only: 15 byte products. b1:b2 live in r14:r15 until column 1 is done.
#define MY1016_PRODUCT_1                                                                                  \
    /* (0,1)@1 fresh into r14:r15 = b1:b2, (1,0)@1: carry into b3 */                                          \
    "mul r22, r19\n\t"                                                                                        \
    "movw r14, r0\n\t"                                                                                        \
    "mul r23, r18\n\t"                                                                                        \
    "clr r27\n\t"                                                                                             \
    "add r14, r0\n\t"                                                                                         \
    "adc r15, r1\n\t"                                                                                         \
    "adc r27, r11\n\t"                                                                                        \
    /* (0,2)@2, no carry; b2 moves from r15 to r26 */                                                         \
    "mul r22, r20\n\t"                                                                                        \
    "mov r26, r0\n\t"                                                                                         \
    "add r26, r15\n\t"                                                                                        \
    "adc r27, r1\n\t"                                                                                         \
    /* (2,0)@2: carry into b4 = r12 */                                                                        \
    "mul r24, r18\n\t"                                                                                        \
    "clr r12\n\t"                                                                                             \
    "add r26, r0\n\t"                                                                                         \
    "adc r27, r1\n\t"                                                                                         \
    "adc r12, r11\n\t"                                                                                        \
    /* (0,3)@3 */                                                                                             \
    "mul r22, r21\n\t"                                                                                        \
    "add r27, r0\n\t"                                                                                         \
    "adc r12, r1\n\t"                                                                                         \
    MY1016_UPPER MY1016_TOP

#else  // the same numbers from 64-bit arithmetic

static inline int64_t my1016_whole(my1016_Word word) { return (int64_t)word.hi * 65536 + word.lo; }

static inline my1016_Word my1016_word(int64_t whole) {
    my1016_Word word = {(uint16_t)(whole & 0xFFFF), (int32_t)(whole >> 16)};
    return word;
}

// d * a without the byte products (i,j) with i + j below `columns`.
static inline int64_t my1016_product(int32_t d, uint32_t a, uint8_t columns) {
    int64_t product = (int64_t)d * (int64_t)a;
    for (uint8_t column = 0; column < columns; ++column) {
        for (uint8_t i = 0; i <= column; ++i) {
            const int64_t part = (int64_t)((d >> 8 * i) & 0xFF) * (int64_t)((a >> 8 * (column - i)) & 0xFF);
            product -= part * ((int64_t)1 << 8 * column);
        }
    }
    return product;
}

static inline int32_t my1016_high16(int32_t d, uint32_t a) { return (int32_t)(my1016_product(d, a, 1) >> 16); }
static inline int32_t my1016_high24(int32_t d, uint32_t a) { return (int32_t)(my1016_product(d, a, 1) >> 24); }
static inline int32_t my1016_high32(int32_t d, uint32_t a) { return (int32_t)(my1016_product(d, a, 2) >> 32); }

static inline void my1016_subtract16(my1016_Word &word, int32_t d, uint32_t a) {
    word = my1016_word(my1016_whole(word) - (my1016_product(d, a, 1) >> 16));
}
static inline void my1016_subtract24(my1016_Word &word, int32_t d, uint32_t a) {
    word = my1016_word(my1016_whole(word) - (my1016_product(d, a, 2) >> 24));
}
static inline void my1016_subtract32(my1016_Word &word, int32_t d, uint32_t a) {
    word = my1016_word(my1016_whole(word) - (my1016_product(d, a, 2) >> 32));
}

static inline void my1016_add(my1016_Word &sum, my1016_Word term) {
    sum = my1016_word(my1016_whole(sum) + my1016_whole(term));
}

static inline void my1016_negate(my1016_Word &word) { word = my1016_word(-my1016_whole(word)); }
static inline my1016_Word my1016_right10(my1016_Word word) {
    return my1016_word(my1016_whole(word) >> 10);
}
static inline my1016_Word my1016_right13(my1016_Word word) {
    return my1016_word(my1016_whole(word) >> 13);
}

#endif  // __AVR__

#if defined(__GNUC__)
#define MY1016_ONE_COPY __attribute__((noinline))
#else
#define MY1016_ONE_COPY
#endif

// Thousandths of a kelvin, limited to a declared range, as x1.hi. The factors are 2^b / 1000 for its b bits after the binary
// point: the whole part, and the 32 bits after it in two halves. To nearest; everything fits 32 bits.
static MY1016_ONE_COPY int32_t my1016_word_of(int32_t rise_mK, int32_t whole, uint16_t upper, uint16_t lower) {
    const int32_t over = rise_mK >> 8;
    int32_t part = over * (int32_t)upper + (int32_t)(((uint32_t)(uint8_t)rise_mK * upper) >> 8);  // in 2^-8
    part += (over * (int32_t)lower) >> 16;
    return rise_mK * whole + ((part + 128) >> 8);
}

// A state at rest at a rise in thousandths of a kelvin.
static inline MY1016_SMALL void my1016_rest(my1016_Word *x, uint8_t words, int32_t rise_mK, int32_t whole, uint16_t upper, uint16_t lower) {
    memset(x, 0, words * sizeof *x);
    x->hi = my1016_word_of(rise_mK, whole, upper, lower);
}

#endif
