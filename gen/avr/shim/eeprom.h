/* The EEPROM: its contents, its write time, a write that is cut short. */
#ifndef GEN_EEPROM_H
#define GEN_EEPROM_H

#include "core.h"

extern const struct part mega_eeprom_part;

uint16_t gen_mega_eeprom_size(const struct gen_mega *mega);
void gen_mega_eeprom_load(struct gen_mega *mega, const uint8_t *bytes);
void gen_mega_eeprom_save(const struct gen_mega *mega, uint8_t *bytes);
int gen_mega_eeprom_busy(const struct gen_mega *mega);

/* Writes begun, and accesses refused because a write was under way. */
void gen_mega_eeprom_counts(const struct gen_mega *mega, uint32_t *writes, uint32_t *refused);

#endif
