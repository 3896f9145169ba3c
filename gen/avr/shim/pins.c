/* Levels that the world puts on pins, and levels that it sees there.
 *
 * What the world drives is kept in simavr's own place for it, external.pull_mask and pull_value of the port: without it
 * simavr would put an input with pull-up to 1 again whenever the firmware writes any pin of that port.
 */
#include "pins.h"

#include <simavr/avr_extint.h>
#include <simavr/avr_ioport.h>

#include <stdlib.h>
#include <string.h>

#define PORTS 12 /* A..L without I */
#define PROBES 16
#define EXTERNAL_INTERRUPTS 8

struct probe {
	struct gen_mega *mega;
	avr_cycle_count_t *cycles;
	uint8_t *levels;
	size_t length, capacity;
};

struct pins {
	avr_ioport_t *ports[PORTS]; /* simavr's own, by letter; NULL where there is none */
	struct probe probes[PROBES];
	int probe_count;
};

static avr_ioport_t *port_of(const struct gen_mega *mega, struct pin pin) /* NULL when there is no such pin */
{
	if (pin.port < 'A' || pin.port >= 'A' + PORTS || pin.bit > 7)
		return NULL;
	return mega->pins->ports[pin.port - 'A'];
}

avr_irq_t *mega_pin(const struct gen_mega *mega, struct pin pin)
{
	avr_ioport_t *port = port_of(mega, pin);
	return port ? port->io.irq + pin.bit : NULL;
}

void mega_drive(struct gen_mega *mega, struct pin pin, int level)
{
	avr_ioport_t *port = port_of(mega, pin);
	uint8_t mask = (uint8_t)(1u << pin.bit);
	const uint8_t *data = mega->avr->data;
	if (!port)
		return;
	if (level < 0) { /* the firmware's output or pull-up acts, else the line keeps its charge */
		port->external.pull_mask &= (uint8_t)~mask;
		level = ((data[port->r_ddr] | data[port->r_port]) & mask ? data[port->r_port] : data[port->r_pin]) & mask;
	} else {
		port->external.pull_mask |= mask;
	}
	level = level != 0;
	port->external.pull_value &= (uint8_t)~mask;
	if (level && port->external.pull_mask & mask)
		port->external.pull_value |= mask;
	avr_raise_irq(port->io.irq + pin.bit, (uint32_t)level);
}

int gen_mega_pin_drive(struct gen_mega *mega, char port, uint8_t bit, int level)
{
	struct pin pin = {port, bit};
	if (!port_of(mega, pin))
		return -1;
	mega_drive(mega, pin, level);
	return 0;
}

int gen_mega_pin_read(const struct gen_mega *mega, char port, uint8_t bit)
{
	const avr_ioport_t *place = port_of(mega, (struct pin){port, bit});
	const uint8_t *data = mega->avr->data;
	if (!place)
		return -1;
	int output = data[place->r_ddr] >> bit & 1, latch = data[place->r_port] >> bit & 1;
	return (output ? latch : data[place->r_pin] >> bit & 1) | output << 1 | latch << 2;
}

/* ---- probes: every change of a pin with its cycle ---- */

static void seen(avr_irq_t *irq, uint32_t value, void *parameter)
{
	(void)irq;
	struct probe *probe = parameter;
	uint8_t level = (value & 0xff) != 0;
	if (probe->length && probe->levels[probe->length - 1] == level)
		return;
	if (probe->length == probe->capacity) {
		size_t capacity = probe->capacity ? 2 * probe->capacity : 256;
		avr_cycle_count_t *cycles = realloc(probe->cycles, capacity * sizeof *cycles);
		if (cycles)
			probe->cycles = cycles;
		uint8_t *levels = realloc(probe->levels, capacity);
		if (levels)
			probe->levels = levels;
		if (!cycles || !levels) {
			mega_note(probe->mega, "out of memory for a pin's changes");
			mega_stop(probe->mega, STOP_PROTOCOL);
			return;
		}
		probe->capacity = capacity;
	}
	probe->cycles[probe->length] = probe->mega->avr->cycle;
	probe->levels[probe->length++] = level;
}

int gen_mega_probe_add(struct gen_mega *mega, char port, uint8_t bit)
{
	avr_irq_t *irq = mega_pin(mega, (struct pin){port, bit});
	if (!irq || mega->pins->probe_count == PROBES)
		return -1;
	struct probe *probe = &mega->pins->probes[mega->pins->probe_count];
	probe->mega = mega;
	avr_irq_register_notify(irq, seen, probe);
	return mega->pins->probe_count++;
}

size_t gen_mega_probe_length(const struct gen_mega *mega, uint32_t probe)
{
	return probe < (uint32_t)mega->pins->probe_count ? mega->pins->probes[probe].length : 0;
}

void gen_mega_probe_copy(const struct gen_mega *mega, uint32_t probe, size_t from, size_t count, uint64_t *cycles,
			 uint8_t *levels)
{
	const struct probe *source = &mega->pins->probes[probe];
	for (size_t i = 0; i < count; i++) {
		cycles[i] = source->cycles[from + i];
		levels[i] = source->levels[from + i];
	}
}

/* ---- the part ---- */

/* simavr polls a low pin at every cycle once the pin has fallen in level mode, the mode after a reset. */
static void stop_polling_levels(struct gen_mega *mega)
{
	for (uint8_t i = 0; i < EXTERNAL_INTERRUPTS; i++)
		avr_extint_set_strict_lvl_trig(mega->avr, i, 0);
}

static int attach(struct gen_mega *mega)
{
	mega->pins = calloc(1, sizeof *mega->pins);
	if (!mega->pins)
		return -1;
	for (avr_io_t *part = mega->avr->io_port; part; part = part->next)
		if (!strcmp(part->kind, "port")) {
			avr_ioport_t *port = (avr_ioport_t *)part;
			mega->pins->ports[port->name - 'A'] = port;
		}
	stop_polling_levels(mega);
	return 0;
}

/* A reset of the chip zeroes its PIN registers without an event: what drives them from outside is still there. */
static void drive_again(struct gen_mega *mega)
{
	for (int i = 0; i < PORTS; i++) {
		avr_ioport_t *port = mega->pins->ports[i];
		for (uint8_t bit = 0; port && bit < 8; bit++) {
			if (port->external.pull_mask >> bit & 1) {
				uint32_t level = port->external.pull_value >> bit & 1;
				port->io.irq[bit].value = !level; /* else simavr sees no change */
				avr_raise_irq(port->io.irq + bit, level);
			} else {
				port->io.irq[bit].value = 0; /* as PIN says: a pull-up set again is a change */
			}
		}
	}
}

static void rearm(struct gen_mega *mega)
{
	stop_polling_levels(mega);
	drive_again(mega);
}

static void close_pins(struct gen_mega *mega)
{
	for (int i = 0; mega->pins && i < mega->pins->probe_count; i++) {
		free(mega->pins->probes[i].cycles);
		free(mega->pins->probes[i].levels);
	}
	free(mega->pins);
}

const struct part mega_pins_part = {.attach = attach, .rearm = rearm, .close = close_pins};
