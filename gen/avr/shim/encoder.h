/* An encoder's pulses. */
#ifndef GEN_ENCODER_H
#define GEN_ENCODER_H

#include "core.h"

extern const struct part mega_encoder_part;

/* batch: its length in cycles, or 0. */
int gen_mega_encoder_attach(struct gen_mega *mega, char port, uint8_t bit, uint64_t batch);

/* Send count pulses within the next span cycles. Pulses of an earlier call that are still due are dropped. */
int gen_mega_encoder_pulses(struct gen_mega *mega, uint32_t count, uint64_t span);

/* Pulses risen until now. */
uint64_t gen_mega_encoder_risen(const struct gen_mega *mega);

#endif
