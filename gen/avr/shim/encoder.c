/* An encoder's pulses.
 *
 * The pulses of one call lie evenly in its span. Pulse i rises at (i + 1/4) span / count and falls half a pulse later;
 * where the firmware has set its interrupt to one kind of edge only, both edges come together, which spares an event.
 *
 * In batches the pin rests: the interrupts of the pulses that fall due within a batch's length are raised at its end, one
 * after the other, each when the firmware has taken the one before. Their number is the same; their spacing is not, and
 * no pulse can be lost in a batch.
 *
 * On the input of Timer 5 (PL2, Arduino pin 47) nothing happens at a pulse: counter.c works the count out when the
 * firmware reads it.
 */
#include "encoder.h"

#include "counter.h"
#include "pins.h"

#include <simavr/avr_extint.h>
#include <simavr/avr_ioport.h>

#include <stdlib.h>
#include <string.h>

#define EXTERNAL_INTERRUPTS 8

struct encoder {
	struct pin pin;
	int attached, level, counted;
	struct avr_int_vector_t *vector; /* of the pin's external interrupt; NULL when it has none */
	const struct avr_regbit_t *sense; /* its ISC bits, both */
	avr_cycle_count_t start, span, batch; /* batch = 0: every edge at its own time */
	uint32_t count, edges;
	uint64_t risen, owed; /* owed: interrupts of a batch that are still to be raised */
};

enum sense { LEVEL = 0, ANY_EDGE = 1, FALLING = 2, RISING = 3 };

static enum sense sense_of(const struct gen_mega *mega)
{
	const struct avr_regbit_t *bits = mega->encoder->sense;
	return bits ? (enum sense)(avr_regbit_get(mega->avr, bits[0]) | avr_regbit_get(mega->avr, bits[1]) << 1) : LEVEL;
}

/* ---- every pulse at its own time ---- */

static avr_cycle_count_t edge_at(const struct encoder *encoder, uint32_t edge)
{
	return encoder->start + (2u * (uint64_t)edge + 1u) * encoder->span / (4u * (uint64_t)encoder->count);
}

static void edge(struct gen_mega *mega)
{
	struct encoder *encoder = mega->encoder;
	encoder->level = !encoder->level;
	encoder->risen += (uint64_t)encoder->level;
	encoder->edges++;
	mega_drive(mega, encoder->pin, encoder->level);
}

static avr_cycle_count_t next_edge(avr_t *avr, avr_cycle_count_t when, void *parameter)
{
	(void)avr;
	(void)when;
	struct gen_mega *mega = parameter;
	struct encoder *encoder = mega->encoder;
	edge(mega);
	if (encoder->level && sense_of(mega) >= FALLING)
		edge(mega);
	return encoder->edges < 2 * encoder->count ? edge_at(encoder, encoder->edges) : 0;
}

/* ---- in batches ---- */

static void raise_owed(struct gen_mega *mega)
{
	struct encoder *encoder = mega->encoder;
	if (!avr_regbit_get(mega->avr, encoder->vector->enable)) {
		encoder->owed = 0; /* as on the chip, where its flag can only be set once */
	} else if (encoder->owed && !encoder->vector->pending) {
		encoder->owed--;
		avr_raise_interrupt(mega->avr, encoder->vector);
	}
}

static void interrupt_taken(avr_irq_t *irq, uint32_t value, void *parameter)
{
	(void)irq;
	struct gen_mega *mega = parameter;
	if (!value && mega->encoder->owed)
		raise_owed(mega);
}

/* The last batch comes one length early, so that it is over when the span ends. */
static avr_cycle_count_t last_batch(const struct encoder *encoder)
{
	return encoder->span - encoder->batch;
}

static avr_cycle_count_t batch_end(const struct encoder *encoder, avr_cycle_count_t now)
{
	avr_cycle_count_t end = encoder->start + ((now - encoder->start) / encoder->batch + 1) * encoder->batch;
	avr_cycle_count_t last = encoder->start + last_batch(encoder);
	return end < last ? end : last;
}

static avr_cycle_count_t next_batch(avr_t *avr, avr_cycle_count_t when, void *parameter)
{
	struct gen_mega *mega = parameter;
	struct encoder *encoder = mega->encoder;
	avr_cycle_count_t now = avr->cycle, passed = now - encoder->start, whole = passed - passed % encoder->batch;
	uint64_t due = passed >= last_batch(encoder) ? encoder->count : whole * encoder->count / encoder->span;
	uint64_t pulses = due - encoder->edges / 2;
	(void)when;
	encoder->edges = (uint32_t)(2 * due);
	encoder->risen += pulses;
	encoder->owed += sense_of(mega) == ANY_EDGE ? 2 * pulses : pulses;
	raise_owed(mega);
	return due < encoder->count ? batch_end(encoder, now) : 0;
}

/* ---- */

static int in_batches(const struct encoder *encoder)
{
	return encoder->batch && encoder->vector;
}

static void encoder_arm(struct gen_mega *mega)
{
	struct encoder *encoder = mega->encoder;
	avr_cycle_count_t now = mega->avr->cycle;
	if (!encoder->attached || encoder->counted || encoder->edges >= 2 * encoder->count)
		return;
	avr_cycle_count_t when = in_batches(encoder) ? batch_end(encoder, now) : edge_at(encoder, encoder->edges);
	avr_cycle_timer_register(mega->avr, when > now ? when - now : 1, in_batches(encoder) ? next_batch : next_edge,
				 mega);
}

static void find_interrupt(struct gen_mega *mega)
{
	struct encoder *encoder = mega->encoder;
	for (avr_io_t *part = mega->avr->io_port; part; part = part->next) {
		if (strcmp(part->kind, "extint") != 0)
			continue;
		avr_extint_t *interrupts = (avr_extint_t *)part;
		for (int i = 0; i < EXTERNAL_INTERRUPTS; i++)
			if (interrupts->eint[i].port_ioctl == (uint32_t)AVR_IOCTL_IOPORT_GETIRQ(encoder->pin.port) &&
			    interrupts->eint[i].port_pin == encoder->pin.bit) {
				encoder->vector = &interrupts->eint[i].vector;
				encoder->sense = interrupts->eint[i].isc;
				avr_irq_register_notify(encoder->vector->irq + AVR_INT_IRQ_PENDING, interrupt_taken,
							mega);
			}
	}
}

/* In a counter's case none of the pulses was an event. */
uint64_t gen_mega_encoder_risen(const struct gen_mega *mega)
{
	const struct encoder *encoder = mega->encoder;
	if (!encoder->counted || !encoder->count)
		return encoder->risen;
	uint64_t passed = mega->avr->cycle - encoder->start;
	uint64_t due = passed >= encoder->span ? encoder->count
					       : (passed * encoder->count + encoder->span / 2) / encoder->span;
	return encoder->risen + due;
}

int gen_mega_encoder_attach(struct gen_mega *mega, char port, uint8_t bit, uint64_t batch)
{
	struct pin pin = {port, bit};
	if (!mega_pin(mega, pin))
		return -1;
	*mega->encoder = (struct encoder){.pin = pin, .attached = 1, .batch = batch};
	mega->encoder->counted = mega_counter_watch(mega, pin, gen_mega_encoder_risen);
	find_interrupt(mega);
	mega_drive(mega, pin, 0);
	return 0;
}

int gen_mega_encoder_pulses(struct gen_mega *mega, uint32_t count, uint64_t span)
{
	struct encoder *encoder = mega->encoder;
	if (!encoder->attached || count > span / 4 || encoder->batch > span / 4)
		return -1;
	avr_cycle_timer_cancel(mega->avr, next_edge, mega);
	avr_cycle_timer_cancel(mega->avr, next_batch, mega);
	if (encoder->level)
		mega_drive(mega, encoder->pin, encoder->level = 0);
	encoder->risen = gen_mega_encoder_risen(mega);
	encoder->start = mega->avr->cycle;
	encoder->span = span;
	encoder->count = count;
	encoder->edges = 0;
	encoder_arm(mega);
	return 0;
}

static int attach(struct gen_mega *mega)
{
	mega->encoder = calloc(1, sizeof *mega->encoder);
	return mega->encoder ? 0 : -1;
}

static void rearm(struct gen_mega *mega)
{
	mega->encoder->owed = 0;
	encoder_arm(mega);
}

static void close_encoder(struct gen_mega *mega)
{
	free(mega->encoder);
}

const struct part mega_encoder_part = {.attach = attach, .rearm = rearm, .close = close_encoder};
