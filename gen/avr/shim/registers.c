/* MAX31856 and MAX31865 converters on bit-banged pins (Maxim, data sheets, "Serial Interface"), SPI mode 1.
 *
 * CS low begins an access. The first byte is an address, its highest bit set for writing; what follows goes to, or
 * comes from, that register and those behind it. The chip puts a bit out when SCK rises and takes one when it falls.
 * Data are those of the last conversion; conversions run while the configuration asks for them, each as long as the
 * longest one, and the chip begins anew when it is told so. Before the first one all data are 0.
 */
#include "registers.h"

#include "pins.h"

#include <stdlib.h>

#define CHIPS 32
#define REGISTERS 16

struct register_chip {
	struct gen_mega *mega;
	struct pin cs, so, sck, sdi;
	int selected, clock, sdi_level;
	int line;                   /* the level to which SO is shorted, or -1 */
	uint8_t registers[REGISTERS];
	uint8_t data_at, data_bytes, converts;
	uint32_t now, before;       /* what a conversion gives at present, and what it gave before the last change */
	avr_cycle_count_t changed, began, conversion;
	uint8_t bits, in, out, address;
	int writing;
	uint32_t reads, early;
};

struct register_chips {
	struct register_chip chip[CHIPS];
	int count;
};

static int converts(const struct register_chip *chip)
{
	return (chip->registers[0] & chip->converts) == chip->converts;
}

static void latch_data(struct register_chip *chip)
{
	avr_cycle_count_t now = chip->mega->avr->cycle;
	uint32_t data = 0;
	chip->reads++;
	if (!converts(chip) || now - chip->began < chip->conversion) {
		chip->early++;
	} else {
		avr_cycle_count_t end = now - (now - chip->began) % chip->conversion;
		data = end >= chip->changed ? chip->now : chip->before;
	}
	for (int i = chip->data_bytes - 1; i >= 0; i--, data >>= 8)
		chip->registers[chip->data_at + i] = (uint8_t)data;
}

static void put_out(struct register_chip *chip, int level)
{
	mega_drive(chip->mega, chip->so, chip->line >= 0 ? chip->line : level);
}

static void cs_changed(avr_irq_t *irq, uint32_t value, void *parameter)
{
	(void)irq;
	struct register_chip *chip = parameter;
	int high = (value & 0xff) != 0;
	if (!high && !chip->selected) {
		chip->selected = 1;
		chip->bits = chip->in = chip->out = 0;
		latch_data(chip);
		put_out(chip, 0);
	} else if (high && chip->selected) {
		chip->selected = 0;
		mega_drive(chip->mega, chip->so, -1);
	}
}

static void sdi_changed(avr_irq_t *irq, uint32_t value, void *parameter)
{
	(void)irq;
	((struct register_chip *)parameter)->sdi_level = (value & 0xff) != 0;
}

static void take_byte(struct register_chip *chip)
{
	if (chip->bits == 8) {
		chip->writing = chip->in >> 7;
		chip->address = chip->in & (REGISTERS - 1);
	} else {
		if (chip->writing && (chip->address < chip->data_at || chip->address >= chip->data_at + chip->data_bytes)) {
			/* The MAX31865 clears its faults when bit 1 of the configuration is written, and the bit with them. */
			chip->registers[chip->address] = chip->address ? chip->in : chip->in & (uint8_t)~0x02;
			if (chip->address == 0)
				chip->began = chip->mega->avr->cycle;
		}
		chip->address = (chip->address + 1) & (REGISTERS - 1);
		chip->bits = 16; /* only whether it is the first byte matters */
	}
	chip->out = chip->registers[chip->address];
}

static void sck_changed(avr_irq_t *irq, uint32_t value, void *parameter)
{
	(void)irq;
	struct register_chip *chip = parameter;
	int high = (value & 0xff) != 0;
	if (high == chip->clock)
		return;
	chip->clock = high;
	if (!chip->selected)
		return;
	if (high) {
		put_out(chip, chip->out >> 7);
		chip->out = (uint8_t)(chip->out << 1);
	} else {
		chip->in = (uint8_t)(chip->in << 1 | chip->sdi_level);
		if (++chip->bits % 8 == 0)
			take_byte(chip);
	}
}

static int attach(struct gen_mega *mega)
{
	mega->register_chips = calloc(1, sizeof *mega->register_chips);
	return mega->register_chips ? 0 : -1;
}

static void forget(struct register_chip *chip)
{
	for (int at = 0; at < REGISTERS; at++)
		chip->registers[at] = 0;
}

/* After a reset of the board its pins float, and the chips' own CS inputs are taken as high. */
static void float_lines(struct gen_mega *mega, int power_lost)
{
	for (int i = 0; i < mega->register_chips->count; i++) {
		struct register_chip *chip = &mega->register_chips->chip[i];
		chip->selected = chip->clock = chip->sdi_level = 0;
		mega_drive(mega, chip->so, -1);
		if (power_lost)
			forget(chip);
	}
}

static void reset(struct gen_mega *mega)
{
	float_lines(mega, 0);
}

static void restored(struct gen_mega *mega)
{
	float_lines(mega, 1);
}

static void close_chips(struct gen_mega *mega)
{
	free(mega->register_chips);
}

const struct part mega_register_chips_part = {
	.attach = attach, .reset = reset, .restored = restored, .close = close_chips};

int gen_mega_register_chip_add(struct gen_mega *mega, char cs_port, uint8_t cs_bit, char so_port, uint8_t so_bit,
			       char sck_port, uint8_t sck_bit, char sdi_port, uint8_t sdi_bit, uint64_t conversion,
			       uint8_t data_at, uint8_t data_bytes, uint8_t converts_bits)
{
	struct pin cs = {cs_port, cs_bit}, so = {so_port, so_bit}, sck = {sck_port, sck_bit}, sdi = {sdi_port, sdi_bit};
	struct register_chips *chips = mega->register_chips;
	if (chips->count == CHIPS || !conversion || data_bytes > 4 || data_at + data_bytes > REGISTERS ||
	    !mega_pin(mega, cs) || !mega_pin(mega, so) || !mega_pin(mega, sck) || !mega_pin(mega, sdi))
		return -1;
	struct register_chip *chip = &chips->chip[chips->count];
	*chip = (struct register_chip){.mega = mega, .cs = cs, .so = so, .sck = sck, .sdi = sdi, .line = -1,
				       .conversion = conversion, .data_at = data_at, .data_bytes = data_bytes,
				       .converts = converts_bits};
	avr_irq_register_notify(mega_pin(mega, cs), cs_changed, chip);
	avr_irq_register_notify(mega_pin(mega, sck), sck_changed, chip);
	avr_irq_register_notify(mega_pin(mega, sdi), sdi_changed, chip);
	return chips->count++;
}

int gen_mega_register_chip_data(struct gen_mega *mega, uint32_t number, uint32_t data, int line)
{
	if (number >= (uint32_t)mega->register_chips->count)
		return -1;
	struct register_chip *chip = &mega->register_chips->chip[number];
	chip->before = chip->now;
	chip->now = data;
	chip->line = line;
	chip->changed = mega->avr->cycle;
	return 0;
}

int gen_mega_register_chip_counts(const struct gen_mega *mega, uint32_t number, uint32_t *reads, uint32_t *early)
{
	if (number >= (uint32_t)mega->register_chips->count)
		return -1;
	*reads = mega->register_chips->chip[number].reads;
	*early = mega->register_chips->chip[number].early;
	return 0;
}

int gen_mega_register_chip_forget(struct gen_mega *mega, uint32_t number)
{
	if (number >= (uint32_t)mega->register_chips->count)
		return -1;
	forget(&mega->register_chips->chip[number]);
	return 0;
}

int gen_mega_register_chip_register(const struct gen_mega *mega, uint32_t number, uint8_t at)
{
	if (number >= (uint32_t)mega->register_chips->count || at >= REGISTERS)
		return -1;
	return mega->register_chips->chip[number].registers[at];
}
