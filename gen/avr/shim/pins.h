/* Levels put on pins, levels seen on pins. */
#ifndef GEN_PINS_H
#define GEN_PINS_H

#include "core.h"

/* A pin of the chip: port 'A'..'L', bit 0..7. */
struct pin {
	char port;
	uint8_t bit;
};

extern const struct part mega_pins_part;

avr_irq_t *mega_pin(const struct gen_mega *mega, struct pin pin); /* NULL when there is no such pin */
void mega_drive(struct gen_mega *mega, struct pin pin, int level); /* level 0 or 1; -1 lets go */

int gen_mega_pin_drive(struct gen_mega *mega, char port, uint8_t bit, int level);

/* Bit 0: the level, bit 1: the firmware drives it, bit 2: the firmware's port bit. -1 when there is no such pin. */
int gen_mega_pin_read(const struct gen_mega *mega, char port, uint8_t bit);

int gen_mega_probe_add(struct gen_mega *mega, char port, uint8_t bit); /* the probe's number, or -1 */
size_t gen_mega_probe_length(const struct gen_mega *mega, uint32_t probe);
void gen_mega_probe_copy(const struct gen_mega *mega, uint32_t probe, size_t from, size_t count, uint64_t *cycles,
			 uint8_t *levels);

#endif
