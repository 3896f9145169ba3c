/* MAX6675 and MAX31855 thermocouple converters on bit-banged pins (Maxim, data sheets, "Serial Interface").
 *
 * A MAX6675's word has 16 bits, a MAX31855's 32; clocked on, both give zeros here (the data sheets say nothing of it).
 * While CS is high the chip converts again and again; a conversion takes 0.17 s, at most 0.22 s. A falling CS stops the
 * conversion under way and puts bit 15 of the last finished one on SO; every falling SCK puts out the next bit. With CS
 * high SO floats, so that several chips can share SO and SCK. A read that comes before a conversion has finished gives
 * the word of the one before. Before its first conversion a chip gives zeros.
 */
#include "max6675.h"

#include "pins.h"

#include <stdlib.h>

#define CHIPS 32

struct chip {
	struct gen_mega *mega;
	struct pin cs, so, sck;
	int selected, clock;
	uint32_t now, before;       /* what a conversion gives at present, and what it gave before the last change */
	uint32_t held;              /* the last finished conversion */
	uint8_t unused;             /* bits of the shift register that its word does not fill: 16 of a MAX6675 */
	uint32_t shifting;          /* what is left to clock out, most significant bit first */
	avr_cycle_count_t changed, high_since, conversion;
	uint32_t reads, early, clashes;
};

struct chips {
	struct chip chip[CHIPS];
	int count;
};

static int same(struct pin a, struct pin b)
{
	return a.port == b.port && a.bit == b.bit;
}

static void put_out(struct chip *chip)
{
	mega_drive(chip->mega, chip->so, chip->shifting >> 31);
}

static void select_chip(struct chip *chip)
{
	struct gen_mega *mega = chip->mega;
	avr_cycle_count_t now = mega->avr->cycle, finished = (now - chip->high_since) / chip->conversion;
	chip->reads++;
	if (finished) { /* a conversion gives what the thermocouple said when it ended */
		avr_cycle_count_t end = chip->high_since + finished * chip->conversion;
		chip->held = end >= chip->changed ? chip->now : chip->before;
	} else {
		chip->early++;
	}
	for (int i = 0; i < mega->chips->count; i++)
		if (mega->chips->chip[i].selected && same(mega->chips->chip[i].so, chip->so))
			chip->clashes++;
	chip->selected = 1;
	chip->shifting = chip->held << chip->unused;
	put_out(chip);
}

static void deselect_chip(struct chip *chip)
{
	chip->selected = 0;
	chip->high_since = chip->mega->avr->cycle;
	for (int i = 0; i < chip->mega->chips->count; i++) {
		struct chip *other = &chip->mega->chips->chip[i];
		if (other->selected && same(other->so, chip->so)) {
			put_out(other);
			return;
		}
	}
	mega_drive(chip->mega, chip->so, -1);
}

static void cs_changed(avr_irq_t *irq, uint32_t value, void *parameter)
{
	(void)irq;
	struct chip *chip = parameter;
	int high = (value & 0xff) != 0;
	if (!high && !chip->selected)
		select_chip(chip);
	else if (high && chip->selected)
		deselect_chip(chip);
}

static void sck_changed(avr_irq_t *irq, uint32_t value, void *parameter)
{
	(void)irq;
	struct chip *chip = parameter;
	int high = (value & 0xff) != 0, fell = chip->clock && !high;
	chip->clock = high;
	if (fell && chip->selected) {
		chip->shifting <<= 1;
		put_out(chip);
	}
}

/* After a reset of the board its pins float, and the chips' own CS inputs are taken as high. */
static void float_lines(struct gen_mega *mega, int power_lost)
{
	struct chips *chips = mega->chips;
	for (int i = 0; i < chips->count; i++) {
		struct chip *chip = &chips->chip[i];
		if (chip->selected || power_lost)
			deselect_chip(chip);
		chip->clock = 0;
		if (power_lost)
			chip->held = 0;
	}
}

static int attach(struct gen_mega *mega)
{
	mega->chips = calloc(1, sizeof *mega->chips);
	return mega->chips ? 0 : -1;
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
	free(mega->chips);
}

const struct part mega_chips_part = {.attach = attach, .reset = reset, .restored = restored, .close = close_chips};

int gen_mega_chip_add(struct gen_mega *mega, char cs_port, uint8_t cs_bit, char so_port, uint8_t so_bit,
		      char sck_port, uint8_t sck_bit, uint64_t conversion, uint8_t bits)
{
	struct pin cs = {cs_port, cs_bit}, so = {so_port, so_bit}, sck = {sck_port, sck_bit};
	if (mega->chips->count == CHIPS || !conversion || !bits || bits > 32 || !mega_pin(mega, cs) || !mega_pin(mega, so) ||
	    !mega_pin(mega, sck))
		return -1;
	struct chip *chip = &mega->chips->chip[mega->chips->count];
	*chip = (struct chip){.mega = mega, .cs = cs, .so = so, .sck = sck, .conversion = conversion,
			      .unused = (uint8_t)(32 - bits), .high_since = mega->avr->cycle};
	avr_irq_register_notify(mega_pin(mega, cs), cs_changed, chip);
	avr_irq_register_notify(mega_pin(mega, sck), sck_changed, chip);
	return mega->chips->count++;
}

int gen_mega_chip_word(struct gen_mega *mega, uint32_t number, uint32_t word)
{
	if (number >= (uint32_t)mega->chips->count)
		return -1;
	struct chip *chip = &mega->chips->chip[number];
	chip->before = chip->now;
	chip->now = word;
	chip->changed = mega->avr->cycle;
	return 0;
}

int gen_mega_chip_counts(const struct gen_mega *mega, uint32_t number, uint32_t *reads, uint32_t *early,
			 uint32_t *clashes)
{
	if (number >= (uint32_t)mega->chips->count)
		return -1;
	*reads = mega->chips->chip[number].reads;
	*early = mega->chips->chip[number].early;
	*clashes = mega->chips->chip[number].clashes;
	return 0;
}
