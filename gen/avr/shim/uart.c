/* UART0: what the firmware sends is kept for Python, what Python sends goes in at the pace of the line. */
#include "uart.h"

#include <simavr/avr_uart.h>

#include <stdlib.h>
#include <string.h>

#define KEEP 65536u /* bytes kept after they were read, so that dropping them is rare */
#define PATTERN_SIZE 256

struct uart {
	avr_irq_t *input;
	int full; /* simavr said XOFF */
	uint8_t *captured;
	size_t captured_length, captured_capacity, taken;
	uint8_t *queue;
	size_t queue_length, queue_head;
	uint64_t byte_cycles; /* spacing of the bytes that go in */
	uint8_t pattern[PATTERN_SIZE];
	size_t pattern_length;
	size_t seen_from; /* the pattern may not reach back before this place in captured */
};

static void uart_output(avr_irq_t *irq, uint32_t value, void *parameter)
{
	(void)irq;
	struct gen_mega *mega = parameter;
	struct uart *uart = mega->uart;
	if (uart->taken > KEEP && uart->seen_from > KEEP) { /* drop what has been read */
		size_t drop = uart->taken < uart->seen_from ? uart->taken : uart->seen_from;
		memmove(uart->captured, uart->captured + drop, uart->captured_length - drop);
		uart->captured_length -= drop;
		uart->taken -= drop;
		uart->seen_from -= drop;
	}
	if (uart->captured_length == uart->captured_capacity) {
		size_t capacity = uart->captured_capacity ? 2 * uart->captured_capacity : 4096;
		uint8_t *larger = realloc(uart->captured, capacity);
		if (!larger) {
			mega_note(mega, "out of memory for the bytes that UART0 sent");
			mega_stop(mega, STOP_PROTOCOL);
			return;
		}
		uart->captured = larger;
		uart->captured_capacity = capacity;
	}
	uart->captured[uart->captured_length++] = (uint8_t)value;
	size_t length = uart->pattern_length;
	if (length && uart->captured_length - uart->seen_from >= length &&
	    !memcmp(uart->captured + uart->captured_length - length, uart->pattern, length)) {
		uart->seen_from = uart->captured_length;
		mega_stop(mega, STOP_PATTERN);
	}
}

static void uart_xon(avr_irq_t *irq, uint32_t value, void *parameter)
{
	(void)irq;
	(void)value;
	((struct gen_mega *)parameter)->uart->full = 0;
}

static void uart_xoff(avr_irq_t *irq, uint32_t value, void *parameter)
{
	(void)irq;
	(void)value;
	((struct gen_mega *)parameter)->uart->full = 1;
}

static avr_cycle_count_t uart_feed(avr_t *avr, avr_cycle_count_t when, void *parameter)
{
	(void)avr;
	struct uart *uart = ((struct gen_mega *)parameter)->uart;
	if (uart->queue_head < uart->queue_length && !uart->full)
		avr_raise_irq(uart->input, uart->queue[uart->queue_head++]);
	return uart->queue_head < uart->queue_length ? when + uart->byte_cycles : 0;
}

static void feed_on(struct gen_mega *mega)
{
	struct uart *uart = mega->uart;
	if (uart->queue_head < uart->queue_length && !avr_cycle_timer_status(mega->avr, uart_feed, mega))
		avr_cycle_timer_register(mega->avr, uart->byte_cycles, uart_feed, mega);
}

static int attach(struct gen_mega *mega)
{
	mega->uart = calloc(1, sizeof *mega->uart);
	if (!mega->uart)
		return -1;
	uint32_t flags = 0; /* no printing, no sleeping while the firmware polls */
	avr_ioctl(mega->avr, AVR_IOCTL_UART_SET_FLAGS('0'), &flags);
	avr_irq_t *base = avr_io_getirq(mega->avr, AVR_IOCTL_UART_GETIRQ('0'), 0);
	mega->uart->input = base + UART_IRQ_INPUT;
	mega->uart->byte_cycles = 1;
	avr_irq_register_notify(base + UART_IRQ_OUTPUT, uart_output, mega);
	avr_irq_register_notify(base + UART_IRQ_OUT_XON, uart_xon, mega);
	avr_irq_register_notify(base + UART_IRQ_OUT_XOFF, uart_xoff, mega);
	return 0;
}

static void reset(struct gen_mega *mega)
{
	mega->uart->full = 0;
}

static void cut(struct gen_mega *mega, uint32_t noise)
{
	(void)noise;
	mega->uart->queue_head = mega->uart->queue_length;
}

static void close_uart(struct gen_mega *mega)
{
	if (!mega->uart)
		return;
	free(mega->uart->captured);
	free(mega->uart->queue);
	free(mega->uart);
}

const struct part mega_uart_part = {
	.attach = attach, .reset = reset, .cut = cut, .rearm = feed_on, .close = close_uart};

int mega_uart_await(struct gen_mega *mega, const uint8_t *pattern, size_t length)
{
	if (length > PATTERN_SIZE) {
		mega_note(mega, "the awaited pattern is longer than %d bytes", PATTERN_SIZE);
		return -1;
	}
	if (length)
		memcpy(mega->uart->pattern, pattern, length);
	mega->uart->pattern_length = length;
	return 0;
}

size_t gen_mega_uart_available(const struct gen_mega *mega)
{
	return mega->uart->captured_length - mega->uart->taken;
}

size_t gen_mega_uart_take(struct gen_mega *mega, uint8_t *to, size_t capacity)
{
	size_t count = gen_mega_uart_available(mega);
	if (count > capacity)
		count = capacity;
	if (count)
		memcpy(to, mega->uart->captured + mega->uart->taken, count);
	mega->uart->taken += count;
	return count;
}

int gen_mega_uart_send(struct gen_mega *mega, const uint8_t *bytes, size_t count, uint32_t byte_cycles)
{
	struct uart *uart = mega->uart;
	if (!count)
		return 0;
	size_t left = uart->queue_length - uart->queue_head;
	uint8_t *queue = malloc(left + count);
	if (!queue)
		return -1;
	if (left)
		memcpy(queue, uart->queue + uart->queue_head, left);
	memcpy(queue + left, bytes, count);
	free(uart->queue);
	uart->queue = queue;
	uart->queue_head = 0;
	uart->queue_length = left + count;
	uart->byte_cycles = byte_cycles ? byte_cycles : 1;
	feed_on(mega);
	return 0;
}

void gen_mega_uart_forget(struct gen_mega *mega)
{
	mega->uart->seen_from = mega->uart->captured_length;
}
