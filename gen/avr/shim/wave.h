/* The PWM signals of another controller, which the firmware may watch. */
#ifndef GEN_WAVE_H
#define GEN_WAVE_H

#include "core.h"

extern const struct part mega_waves_part;

/* A signal that is high for some cycles of every period; 0: low for good, period: high for good. A new share begins
 * with the next edge. */
int gen_mega_wave(struct gen_mega *mega, char port, uint8_t bit, uint32_t period, uint32_t high);

#endif
