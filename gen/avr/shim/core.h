/* The bottom of the shim: the one handle, what a part of the board is, and how a part stops a run or leaves a message.
 *
 * It knows no part by what it holds: each keeps its state behind its own pointer, which its attach() fills and its
 * close() frees. mega.c alone lists the parts.
 */
#ifndef GEN_CORE_H
#define GEN_CORE_H

#include <simavr/sim_avr.h>

#include <stddef.h>
#include <stdint.h>

#define FREQUENCY_HZ 16000000u
#define MESSAGE_SIZE 256

/* Why a run ended; simulator.py holds the same numbers. */
enum gen_stop {
	STOP_LIMIT = 0,   /* the cycle limit */
	STOP_PATTERN = 1, /* the awaited bytes left UART0 */
	STOP_ENDED = 2,   /* the firmware executed cli; sleep */
	STOP_CRASHED = 3, /* illegal opcode, address or jump: see the message */
	STOP_RECORDS = 4, /* every record is done */
	STOP_PROTOCOL = 5, /* the firmware broke the mailbox protocol: see the message */
	STOP_PLACE = 6    /* the program counter reached the awaited place */
};

struct gen_mega;

/* What a part does when something happens to the chip; NULL where it does nothing. */
struct part {
	int (*attach)(struct gen_mega *mega); /* makes its state and hooks into simavr; 0 when it worked */
	void (*reset)(struct gen_mega *mega); /* any reset of the chip, from within simavr's own */
	void (*cut)(struct gen_mega *mega, uint32_t noise); /* the power goes */
	void (*restored)(struct gen_mega *mega); /* the power is back, and the chip has been reset */
	void (*rearm)(struct gen_mega *mega); /* before the chip runs on: a reset drops all of simavr's cycle timers */
	void (*close)(struct gen_mega *mega); /* frees its state, if attach() got so far */
};

struct gen_mega {
	avr_t *avr;
	char message[MESSAGE_SIZE];
	int stop;        /* an enum gen_stop, valid when stopped is set */
	int stopped;     /* a hook asked the run to end */
	int crashed;     /* for good */
	int astray;      /* a firmware that has gone astray goes on, as on a chip */
	int resume;      /* simavr's state before the stop */
	uint32_t resets; /* since the first one */
	int timers_lost; /* a reset dropped the cycle timers */
	avr_cycle_count_t limit;
	avr_cycle_count_t asleep; /* cycles slept */
	avr_cycle_count_t woke, longest_awake;
	void (*core_reset)(avr_t *);
	const struct part *const *parts; /* ends with NULL */
	struct pins *pins; /* from here on: each part's own */
	struct uart *uart;
	struct records *records;
	struct chips *chips;
	struct register_chips *register_chips;
	struct counter *counter;
	struct encoder *encoder;
	struct waves *waves;
	struct eeprom *eeprom;
};

void mega_stop(struct gen_mega *mega, int reason);
void mega_note(struct gen_mega *mega, const char *format, ...) __attribute__((format(printf, 2, 3)));

#endif
