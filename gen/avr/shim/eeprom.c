/* The EEPROM as the data sheet of the ATmega2560 has it (section 8.3): a write takes 3.4 ms (erase and write) or 1.8 ms
 * (one of them), EEPE stays set so long, and the firmware can neither read nor write meanwhile. simavr alone writes at
 * once. When the power goes in mid-write the byte stays half done.
 */
#include "eeprom.h"

#include <simavr/avr_eeprom.h>

#include <stdlib.h>
#include <string.h>

#define EECR 0x3f /* data address */
#define EEDR 0x40
#define EEARL 0x41
#define EEARH 0x42
#define EERE 1u
#define EEPE 2u
#define EEMPE 4u
#define EEPM 0x30u
#define ERASE_AND_WRITE 54400u /* cycles: 3.4 ms */
#define ONE_OF_BOTH 28800u     /* 1.8 ms */

struct eeprom {
	avr_io_write_t write; /* simavr's own handler of EECR */
	void *write_parameter;
	uint8_t *bytes;
	uint16_t size, address;
	uint8_t old, wanted;
	int busy;
	avr_cycle_count_t started, duration;
	uint32_t writes, refused;
};

static avr_cycle_count_t finished(avr_t *avr, avr_cycle_count_t when, void *parameter)
{
	(void)when;
	struct gen_mega *mega = parameter;
	mega->eeprom->busy = 0;
	avr->data[EECR] &= (uint8_t)~EEPE;
	return 0;
}

static void control_written(avr_t *avr, avr_io_addr_t address, uint8_t value, void *parameter)
{
	struct gen_mega *mega = parameter;
	struct eeprom *eeprom = mega->eeprom;
	int armed = avr->data[EECR] & EEMPE;
	if (eeprom->busy) {
		if (value & EERE || (armed && value & EEPE))
			eeprom->refused++;
		eeprom->write(avr, address, (uint8_t)(value & ~(EEPE | EERE)), eeprom->write_parameter);
		avr->data[EECR] |= EEPE;
		return;
	}
	int begins = armed && value & EEPE;
	uint16_t place = (uint16_t)((avr->data[EEARL] | avr->data[EEARH] << 8) % eeprom->size);
	uint8_t old = eeprom->bytes[place];
	eeprom->write(avr, address, value, eeprom->write_parameter);
	if (!begins)
		return;
	uint8_t given = avr->data[EEDR], mode = (uint8_t)(value & EEPM) >> 4;
	eeprom->wanted = mode == 0 ? given : mode == 1 ? 0xff : (uint8_t)(old & given);
	eeprom->duration = mode == 0 ? ERASE_AND_WRITE : ONE_OF_BOTH;
	eeprom->bytes[place] = eeprom->wanted;
	eeprom->address = place;
	eeprom->old = old;
	eeprom->started = avr->cycle;
	eeprom->busy = 1;
	eeprom->writes++;
	avr->data[EECR] |= EEPE;
	avr_cycle_timer_register(avr, eeprom->duration, finished, mega);
}

static int attach(struct gen_mega *mega)
{
	mega->eeprom = calloc(1, sizeof *mega->eeprom);
	if (!mega->eeprom)
		return -1;
	unsigned slot = AVR_DATA_TO_IO(EECR);
	avr_eeprom_t *own = mega->avr->io[slot].w.param;
	mega->eeprom->write = mega->avr->io[slot].w.c;
	mega->eeprom->write_parameter = own;
	mega->eeprom->bytes = own->eeprom;
	mega->eeprom->size = own->size;
	mega->avr->io[slot].w.c = control_written;
	mega->avr->io[slot].w.param = mega;
	return 0;
}

/* A reset that leaves the power on does not stop a write. */
static void rearm(struct gen_mega *mega)
{
	struct eeprom *eeprom = mega->eeprom;
	avr_cycle_count_t now = mega->avr->cycle, end = eeprom->started + eeprom->duration;
	if (!eeprom->busy)
		return;
	mega->avr->data[EECR] |= EEPE;
	avr_cycle_timer_register(mega->avr, end > now ? end - now : 1, finished, mega);
}

/* The power goes: of the byte in writing some bits are erased (first half) or some bits programmed (second half). */
static void cut(struct gen_mega *mega, uint32_t noise)
{
	struct eeprom *eeprom = mega->eeprom;
	if (!eeprom->busy)
		return;
	uint8_t some = (uint8_t)noise;
	int erasing = mega->avr->cycle - eeprom->started < eeprom->duration / 2;
	eeprom->bytes[eeprom->address] = erasing ? eeprom->old | some : eeprom->wanted | some;
	eeprom->busy = 0;
}

static void close_eeprom(struct gen_mega *mega)
{
	free(mega->eeprom);
}

const struct part mega_eeprom_part = {.attach = attach, .cut = cut, .rearm = rearm, .close = close_eeprom};

uint16_t gen_mega_eeprom_size(const struct gen_mega *mega)
{
	return mega->eeprom->size;
}

void gen_mega_eeprom_load(struct gen_mega *mega, const uint8_t *bytes)
{
	memcpy(mega->eeprom->bytes, bytes, mega->eeprom->size);
}

void gen_mega_eeprom_save(const struct gen_mega *mega, uint8_t *bytes)
{
	memcpy(bytes, mega->eeprom->bytes, mega->eeprom->size);
}

int gen_mega_eeprom_busy(const struct gen_mega *mega)
{
	return mega->eeprom->busy;
}

void gen_mega_eeprom_counts(const struct gen_mega *mega, uint32_t *writes, uint32_t *refused)
{
	*writes = mega->eeprom->writes;
	*refused = mega->eeprom->refused;
}
