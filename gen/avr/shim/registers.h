/* MAX31856 and MAX31865 converters: registers behind four bit-banged pins. */
#ifndef GEN_REGISTERS_H
#define GEN_REGISTERS_H

#include "core.h"

extern const struct part mega_register_chips_part;

/* A chip whose data begin at a register and have so many bytes, and which converts while register 0 has the bits of
 * `converts` set. The chip's number, or -1. */
int gen_mega_register_chip_add(struct gen_mega *mega, char cs_port, uint8_t cs_bit, char so_port, uint8_t so_bit,
			       char sck_port, uint8_t sck_bit, char sdi_port, uint8_t sdi_bit, uint64_t conversion,
			       uint8_t data_at, uint8_t data_bytes, uint8_t converts);

/* What a conversion gives from now on, most significant byte first. line: -1, or the level to which its SO is shorted.
 * 0 when it worked. */
int gen_mega_register_chip_data(struct gen_mega *mega, uint32_t number, uint32_t data, int line);

/* Falling edges of its CS; those before a conversion had finished. */
int gen_mega_register_chip_counts(const struct gen_mega *mega, uint32_t number, uint32_t *reads, uint32_t *early);

/* The chip alone loses its supply for a moment: its registers are 0 again. 0 when it worked. */
int gen_mega_register_chip_forget(struct gen_mega *mega, uint32_t number);

/* What a register holds; -1 when there is none. */
int gen_mega_register_chip_register(const struct gen_mega *mega, uint32_t number, uint8_t at);

#endif
