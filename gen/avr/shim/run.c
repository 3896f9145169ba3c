#include "run.h"

static avr_cycle_count_t at_limit(avr_t *avr, avr_cycle_count_t when, void *parameter)
{
	(void)avr;
	(void)when;
	mega_stop(parameter, STOP_LIMIT);
	return 0;
}

static void rearm(struct gen_mega *mega) /* what a reset, or a first start, takes */
{
	mega->timers_lost = 0;
	for (const struct part *const *part = mega->parts; *part; part++)
		if ((*part)->rearm)
			(*part)->rearm(mega);
}

static void arm(struct gen_mega *mega)
{
	avr_cycle_count_t now = mega->avr->cycle;
	if (mega->timers_lost)
		rearm(mega);
	avr_cycle_timer_cancel(mega->avr, at_limit, mega);
	avr_cycle_timer_register(mega->avr, mega->limit > now ? mega->limit - now : 1, at_limit, mega);
}

static void wake(struct gen_mega *mega)
{
	avr_t *avr = mega->avr;
	if (avr->state != cpu_Stopped)
		return;
	/* An interrupt that was raised in the moment of the stop found nobody asleep to wake. */
	int woken = mega->resume == cpu_Sleeping && avr_has_pending_interrupts(avr);
	avr->state = woken ? cpu_Running : mega->resume;
}

/* What a chip does where simavr gives up: its program counter has no more bits than its flash has words; an access where
 * there is no memory is none; sleep without interrupts lasts until the watchdog ends it.
 */
static int goes_on(avr_t *avr, int state)
{
	avr->pc &= avr->flashend;
	avr->state = state == cpu_Done ? cpu_Sleeping : cpu_Running;
	if (avr->state == cpu_Sleeping) { /* simavr lets no time pass in a sleep that no interrupt can end */
		avr_cycle_count_t until = avr_cycle_timer_process(avr), most = FREQUENCY_HZ / 1000;
		until = until < most ? until : most; /* the watchdog's reset comes with the next instruction, not at once */
		avr->sleep(avr, until);
		avr->cycle += 1 + until;
	}
	return avr->state;
}

static int run(struct gen_mega *mega, uint64_t limit, int64_t place)
{
	avr_t *avr = mega->avr;
	if (mega->crashed)
		return STOP_CRASHED;
	if (avr->state == cpu_Done)
		return STOP_ENDED;
	if (avr->cycle >= limit)
		return STOP_LIMIT;
	wake(mega);
	mega->limit = limit;
	mega->stopped = 0;
	arm(mega);
	while (!mega->stopped) {
		int state = avr_run(avr);
		if (mega->stopped)
			break;
		if (mega->astray && (state == cpu_Crashed || state == cpu_Done))
			state = goes_on(avr, state);
		if (state == cpu_Crashed) {
			if (!mega->crashed)
				mega_note(mega, "the firmware jumped to an address outside its flash");
			mega->crashed = 1;
			return STOP_CRASHED;
		}
		if (state == cpu_Done)
			return STOP_ENDED;
		if (mega->timers_lost)
			arm(mega);
		if (place >= 0 && avr->pc == (avr_flashaddr_t)place)
			mega_stop(mega, STOP_PLACE);
	}
	avr_cycle_timer_cancel(avr, at_limit, mega);
	return mega->stop;
}

int mega_run(struct gen_mega *mega, uint64_t limit)
{
	return run(mega, limit, -1);
}

int mega_run_to(struct gen_mega *mega, uint64_t limit, uint32_t place)
{
	avr_cycle_count_t kept = mega->avr->run_cycle_limit;
	mega->avr->run_cycle_limit = 1;
	mega->avr->run_cycle_count = 1;
	int reason = run(mega, limit, place);
	mega->avr->run_cycle_limit = kept;
	return reason;
}
