/* UART0: what the firmware sends is kept for Python, what Python sends goes in at the pace of the line. */
#include "mega.h"

#include <simavr/avr_uart.h>

#include <stdlib.h>
#include <string.h>

#define KEEP 65536u /* bytes kept after they were read, so that dropping them is rare */

static void uart_output(avr_irq_t *irq, uint32_t value, void *parameter)
{
	(void)irq;
	struct gen_mega *mega = parameter;
	struct uart *uart = &mega->uart;
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
	((struct gen_mega *)parameter)->uart.full = 0;
}

static void uart_xoff(avr_irq_t *irq, uint32_t value, void *parameter)
{
	(void)irq;
	(void)value;
	((struct gen_mega *)parameter)->uart.full = 1;
}

static avr_cycle_count_t uart_feed(avr_t *avr, avr_cycle_count_t when, void *parameter)
{
	(void)avr;
	struct uart *uart = &((struct gen_mega *)parameter)->uart;
	if (uart->queue_head < uart->queue_length && !uart->full)
		avr_raise_irq(uart->input, uart->queue[uart->queue_head++]);
	return uart->queue_head < uart->queue_length ? when + uart->byte_cycles : 0;
}

void mega_uart_attach(struct gen_mega *mega)
{
	uint32_t flags = 0; /* no printing, no sleeping while the firmware polls */
	avr_ioctl(mega->avr, AVR_IOCTL_UART_SET_FLAGS('0'), &flags);
	avr_irq_t *base = avr_io_getirq(mega->avr, AVR_IOCTL_UART_GETIRQ('0'), 0);
	mega->uart.input = base + UART_IRQ_INPUT;
	mega->uart.byte_cycles = 1;
	avr_irq_register_notify(base + UART_IRQ_OUTPUT, uart_output, mega);
	avr_irq_register_notify(base + UART_IRQ_OUT_XON, uart_xon, mega);
	avr_irq_register_notify(base + UART_IRQ_OUT_XOFF, uart_xoff, mega);
}

void mega_uart_rearm(struct gen_mega *mega)
{
	struct uart *uart = &mega->uart;
	if (uart->queue_head < uart->queue_length && !avr_cycle_timer_status(mega->avr, uart_feed, mega))
		avr_cycle_timer_register(mega->avr, uart->byte_cycles, uart_feed, mega);
}

void mega_uart_close(struct gen_mega *mega)
{
	free(mega->uart.captured);
	free(mega->uart.queue);
}

size_t gen_mega_uart_available(const struct gen_mega *mega)
{
	return mega->uart.captured_length - mega->uart.taken;
}

size_t gen_mega_uart_take(struct gen_mega *mega, uint8_t *to, size_t capacity)
{
	size_t count = gen_mega_uart_available(mega);
	if (count > capacity)
		count = capacity;
	if (count)
		memcpy(to, mega->uart.captured + mega->uart.taken, count);
	mega->uart.taken += count;
	return count;
}

/* Queue bytes for the receiver, one every byte_cycles from now on. 0 when it worked. */
int gen_mega_uart_send(struct gen_mega *mega, const uint8_t *bytes, size_t count, uint32_t byte_cycles)
{
	struct uart *uart = &mega->uart;
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
	mega_uart_rearm(mega);
	return 0;
}

/* Forget what UART0 sent so far as far as patterns go: a pattern must lie wholly in later bytes. */
void gen_mega_uart_forget(struct gen_mega *mega)
{
	mega->uart.seen_from = mega->uart.captured_length;
}
