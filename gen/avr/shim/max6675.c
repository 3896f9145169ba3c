/* MAX6675 thermocouple converters on bit-banged pins (Maxim, MAX6675 data sheet, "Serial Interface").
 *
 * While CS is high the chip converts again and again; a conversion takes 0.17 s, at most 0.22 s. A falling CS stops the
 * conversion under way and puts bit 15 of the last finished one on SO; every falling SCK puts out the next bit. With CS
 * high SO floats, so that several chips can share SO and SCK. A read that comes before a conversion has finished gives
 * the word of the one before. Before its first conversion a chip gives zeros.
 */
#include "mega.h"

static int same(struct pin a, struct pin b)
{
	return a.port == b.port && a.bit == b.bit;
}

static void put_out(struct chip *chip)
{
	mega_drive(chip->mega, chip->so, chip->shifting >> 15);
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
	for (int i = 0; i < mega->chip_count; i++)
		if (mega->chips[i].selected && same(mega->chips[i].so, chip->so))
			chip->clashes++;
	chip->selected = 1;
	chip->shifting = chip->held;
	put_out(chip);
}

static void deselect_chip(struct chip *chip)
{
	chip->selected = 0;
	chip->high_since = chip->mega->avr->cycle;
	for (int i = 0; i < chip->mega->chip_count; i++) {
		struct chip *other = &chip->mega->chips[i];
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
		chip->shifting = (uint16_t)(chip->shifting << 1);
		put_out(chip);
	}
}

/* After a reset of the board its pins float, and the chips' own CS inputs are taken as high. */
void mega_chips_reset(struct gen_mega *mega, int power_lost)
{
	for (int i = 0; i < mega->chip_count; i++) {
		struct chip *chip = &mega->chips[i];
		if (chip->selected || power_lost)
			deselect_chip(chip);
		chip->clock = 0;
		if (power_lost)
			chip->held = 0;
	}
}

int gen_mega_chip_add(struct gen_mega *mega, char cs_port, uint8_t cs_bit, char so_port, uint8_t so_bit,
		      char sck_port, uint8_t sck_bit, uint64_t conversion) /* the chip's number, or -1 */
{
	struct pin cs = {cs_port, cs_bit}, so = {so_port, so_bit}, sck = {sck_port, sck_bit};
	if (mega->chip_count == CHIPS || !conversion || !mega_pin(mega, cs) || !mega_pin(mega, so) ||
	    !mega_pin(mega, sck))
		return -1;
	struct chip *chip = &mega->chips[mega->chip_count];
	*chip = (struct chip){.mega = mega, .cs = cs, .so = so, .sck = sck, .conversion = conversion,
			      .high_since = mega->avr->cycle};
	avr_irq_register_notify(mega_pin(mega, cs), cs_changed, chip);
	avr_irq_register_notify(mega_pin(mega, sck), sck_changed, chip);
	return mega->chip_count++;
}

/* The word that a conversion gives from now on. 0 when it worked. */
int gen_mega_chip_word(struct gen_mega *mega, uint32_t number, uint16_t word)
{
	if (number >= (uint32_t)mega->chip_count)
		return -1;
	struct chip *chip = &mega->chips[number];
	chip->before = chip->now;
	chip->now = word;
	chip->changed = mega->avr->cycle;
	return 0;
}

/* Reads begun; those before a conversion had finished; those while another chip drove the same SO. */
int gen_mega_chip_counts(const struct gen_mega *mega, uint32_t number, uint32_t *reads, uint32_t *early,
			 uint32_t *clashes)
{
	if (number >= (uint32_t)mega->chip_count)
		return -1;
	*reads = mega->chips[number].reads;
	*early = mega->chips[number].early;
	*clashes = mega->chips[number].clashes;
	return 0;
}
