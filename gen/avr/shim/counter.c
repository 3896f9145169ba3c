/* Timer 5 as a counter of the pulses on its input T5 (PL2, Arduino pin 47).
 *
 * simavr does not count there. The count is worked out when the firmware reads TCNT5, from the pulses that have risen
 * by then: exact at every read, and it costs nothing between reads. Normal mode only; neither overflow nor compare
 * interrupts.
 */
#include "mega.h"

#define TCCR5B 0x121 /* data addresses */
#define TCNT5L 0x124
#define TCNT5H 0x125
#define CLOCK 7u
#define EXTERNAL_FALLING 6u

static int counting(const struct gen_mega *mega)
{
	return (mega->avr->data[TCCR5B] & CLOCK) >= EXTERNAL_FALLING;
}

static uint16_t count_now(const struct gen_mega *mega)
{
	const struct counter *counter = &mega->counter;
	return (uint16_t)(counter->value + (counting(mega) ? mega_encoder_risen(mega) - counter->since : 0));
}

static void set_count(struct gen_mega *mega, uint16_t value)
{
	mega->counter.value = value;
	mega->counter.since = mega_encoder_risen(mega);
}

static uint8_t count_read(avr_t *avr, avr_io_addr_t address, void *parameter)
{
	struct gen_mega *mega = parameter;
	if (!counting(mega))
		return mega->counter.read ? mega->counter.read(avr, address, mega->counter.read_parameter) : avr->data[address];
	uint16_t value = count_now(mega);
	avr->data[TCNT5L] = (uint8_t)value; /* reading the low byte latches the high one */
	avr->data[TCNT5H] = (uint8_t)(value >> 8);
	return avr->data[address];
}

static void count_written(avr_t *avr, avr_io_addr_t address, uint8_t value, void *parameter)
{
	struct gen_mega *mega = parameter;
	mega->counter.count_write(avr, address, value, mega->counter.count_parameter);
	set_count(mega, (uint16_t)(avr->data[TCNT5H] << 8 | value)); /* the high byte was written first */
}

static void clock_written(avr_t *avr, avr_io_addr_t address, uint8_t value, void *parameter)
{
	struct gen_mega *mega = parameter;
	set_count(mega, count_now(mega));
	uint8_t shown = (value & CLOCK) >= EXTERNAL_FALLING ? (uint8_t)(value & ~CLOCK) : value;
	mega->counter.clock_write(avr, address, shown, mega->counter.clock_parameter); /* to simavr it stands still */
	avr->data[address] = value;
}

void mega_counter_reset(struct gen_mega *mega)
{
	set_count(mega, 0);
}

int mega_counter_attach(struct gen_mega *mega, struct pin pin) /* whether the pin is the counter's input */
{
	if (pin.port != 'L' || pin.bit != 2)
		return 0;
	avr_t *avr = mega->avr;
	struct counter *counter = &mega->counter;
	unsigned count = AVR_DATA_TO_IO(TCNT5L), clock = AVR_DATA_TO_IO(TCCR5B);
	if (avr->io[count].w.c == count_written)
		return 1;
	counter->read_parameter = avr->io[count].r.param;
	counter->count_parameter = avr->io[count].w.param;
	counter->clock_parameter = avr->io[clock].w.param;
	counter->read = avr->io[count].r.c;
	counter->count_write = avr->io[count].w.c;
	counter->clock_write = avr->io[clock].w.c;
	avr->io[count].r.c = count_read;
	avr->io[count].w.c = count_written;
	avr->io[clock].w.c = clock_written;
	avr->io[count].r.param = avr->io[count].w.param = avr->io[clock].w.param = mega;
	return 1;
}
