/* MAX6675 and MAX31855 thermocouple converters on bit-banged pins. */
#ifndef GEN_MAX6675_H
#define GEN_MAX6675_H

#include "core.h"

extern const struct part mega_chips_part;

int gen_mega_chip_add(struct gen_mega *mega, char cs_port, uint8_t cs_bit, char so_port, uint8_t so_bit,
		      char sck_port, uint8_t sck_bit, uint64_t conversion, uint8_t bits); /* the chip's number, or -1 */

/* The word that a conversion gives from now on. 0 when it worked. */
int gen_mega_chip_word(struct gen_mega *mega, uint32_t number, uint32_t word);

/* Reads begun; those before a conversion had finished; those while another chip drove the same SO. */
int gen_mega_chip_counts(const struct gen_mega *mega, uint32_t number, uint32_t *reads, uint32_t *early,
			 uint32_t *clashes);

#endif
