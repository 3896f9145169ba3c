/* Timer 5 counting the pulses on its input. */
#ifndef GEN_COUNTER_H
#define GEN_COUNTER_H

#include "pins.h"

extern const struct part mega_counter_part;

/* Let Timer 5 count what risen() says has risen on a pin so far. Whether the pin is its input. */
int mega_counter_watch(struct gen_mega *mega, struct pin pin, uint64_t (*risen)(const struct gen_mega *));

#endif
