/* Timer 5 as a counter of the pulses on its input T5 (PL2, Arduino pin 47).
 *
 * simavr does not count there. The count is worked out when the firmware reads TCNT5, from the pulses that have risen
 * by then: exact at every read, and it costs nothing between reads. Normal mode only; neither overflow nor compare
 * interrupts.
 */
#include "counter.h"

#include <stdlib.h>

#define TCCR5B 0x121 /* data addresses */
#define TCNT5L 0x124
#define TCNT5H 0x125
#define CLOCK 7u
#define EXTERNAL_FALLING 6u

struct counter {
	avr_io_read_t read; /* simavr's own handlers */
	avr_io_write_t count_write, clock_write;
	void *read_parameter, *count_parameter, *clock_parameter;
	uint64_t (*risen)(const struct gen_mega *); /* NULL: nothing to count */
	uint16_t value; /* the count when risen pulses stood at since */
	uint64_t since;
};

static int counting(const struct gen_mega *mega)
{
	return (mega->avr->data[TCCR5B] & CLOCK) >= EXTERNAL_FALLING;
}

static uint16_t count_now(const struct gen_mega *mega)
{
	const struct counter *counter = mega->counter;
	return (uint16_t)(counter->value + (counting(mega) ? counter->risen(mega) - counter->since : 0));
}

static void set_count(struct gen_mega *mega, uint16_t value)
{
	mega->counter->value = value;
	mega->counter->since = mega->counter->risen(mega);
}

static uint8_t count_read(avr_t *avr, avr_io_addr_t address, void *parameter)
{
	struct gen_mega *mega = parameter;
	const struct counter *counter = mega->counter;
	if (!counting(mega))
		return counter->read ? counter->read(avr, address, counter->read_parameter) : avr->data[address];
	uint16_t value = count_now(mega);
	avr->data[TCNT5L] = (uint8_t)value; /* reading the low byte latches the high one */
	avr->data[TCNT5H] = (uint8_t)(value >> 8);
	return avr->data[address];
}

static void count_written(avr_t *avr, avr_io_addr_t address, uint8_t value, void *parameter)
{
	struct gen_mega *mega = parameter;
	mega->counter->count_write(avr, address, value, mega->counter->count_parameter);
	set_count(mega, (uint16_t)(avr->data[TCNT5H] << 8 | value)); /* the high byte was written first */
}

static void clock_written(avr_t *avr, avr_io_addr_t address, uint8_t value, void *parameter)
{
	struct gen_mega *mega = parameter;
	set_count(mega, count_now(mega));
	uint8_t shown = (value & CLOCK) >= EXTERNAL_FALLING ? (uint8_t)(value & ~CLOCK) : value;
	mega->counter->clock_write(avr, address, shown, mega->counter->clock_parameter); /* to simavr it stands still */
	avr->data[address] = value;
}

int mega_counter_watch(struct gen_mega *mega, struct pin pin, uint64_t (*risen)(const struct gen_mega *))
{
	if (pin.port != 'L' || pin.bit != 2)
		return 0;
	avr_t *avr = mega->avr;
	struct counter *counter = mega->counter;
	unsigned count = AVR_DATA_TO_IO(TCNT5L), clock = AVR_DATA_TO_IO(TCCR5B);
	counter->risen = risen;
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

static int attach(struct gen_mega *mega)
{
	mega->counter = calloc(1, sizeof *mega->counter);
	return mega->counter ? 0 : -1;
}

static void reset(struct gen_mega *mega)
{
	if (mega->counter->risen)
		set_count(mega, 0);
}

static void close_counter(struct gen_mega *mega)
{
	free(mega->counter);
}

const struct part mega_counter_part = {.attach = attach, .reset = reset, .close = close_counter};
