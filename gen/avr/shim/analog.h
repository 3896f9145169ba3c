/* Voltages at the converter's inputs, and the supply that it compares them with. */
#ifndef GEN_ANALOG_H
#define GEN_ANALOG_H

#include "core.h"

extern const struct part mega_analog_part;

/* A voltage at an input of the converter, 0..15. */
int gen_mega_adc(struct gen_mega *mega, uint8_t input, uint32_t millivolts);

/* The supply, of the chip and of its converter, and the chip's own reference: 5000 and 1100 mV until told otherwise. */
int gen_mega_supply(struct gen_mega *mega, uint32_t millivolts, uint32_t reference);

#endif
