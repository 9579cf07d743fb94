// SPDX-License-Identifier: GPL-2.0
/*
 * The hardware of one haptic arm without the arm, for tests in a virtual machine: the drivers and device files that a
 * board with real hardware has, and behind them a process that simulates motors and encoders.
 *
 *   counter    three counts that latch at a capture event
 *   SPI bus 0  two spidevs; on chip select 0 an AD5754R listens (mode 1, 24-bit frames), and on 1 one whose outputs nobody reads
 *   GPIO line  HEARTBEAT, an output: each rising edge triggers a one-shot of 5 ms
 *   /dev/arm_hardware
 *              write: struct arm_counts, the encoders; it latches them and pushes the capture event
 *              read:  struct arm_outputs, the converter as it is now
 *
 * /sys/module/arm_hardware/parameters/spi_error: an errno; transfers then fail with it, and the converter keeps what
 * it has. .../one_shot: 1 while the one-shot runs. eqep=1: the counts are also there as three counters with one count each, with the names
 * that the eQEP units of an AM335x have.
 */
#include <linux/counter.h>
#include <linux/fs.h>
#include <linux/gpio/driver.h>
#include <linux/hrtimer.h>
#include <linux/ktime.h>
#include <linux/miscdevice.h>
#include <linux/module.h>
#include <linux/platform_device.h>
#include <linux/spi/spi.h>
#include <linux/spinlock.h>
#include <linux/uaccess.h>

#define JOINTS 3
#define OUTPUTS 4
#define CONVERTERS 2
#define FRAME_BYTES 3

struct arm_counts {
	u32 count[JOINTS];
};

struct arm_outputs {
	s16 word[OUTPUTS];	/* two's complement, of the range */
	u16 range[OUTPUTS];	/* code of the range register */
	u16 power;		/* power register */
	u16 bad_frames;		/* in another mode, or of another length */
	u32 loads;
	u64 last_load_ns;	/* CLOCK_MONOTONIC */
};

static int spi_error;
module_param(spi_error, int, 0644);

static int one_shot;
module_param(one_shot, int, 0444);

static bool eqep;
module_param(eqep, bool, 0444);

static DEFINE_SPINLOCK(lock);
static struct arm_counts counts;	/* as the process wrote them */
static enum counter_function function[JOINTS];
static u64 ceiling[JOINTS] = { 65535, 65535, 65535 };
static u8 enabled[JOINTS];
static struct arm_outputs outputs;
static s16 waiting[OUTPUTS];	/* voltages that no load has taken yet */

/* ------------------------------------------------------------------ counter */

static int count_read(struct counter_device *dev, struct counter_count *count, u64 *value)
{
	unsigned long flags;

	spin_lock_irqsave(&lock, flags);
	*value = enabled[count->id] ? counts.count[count->id] & ceiling[count->id] : 0;
	spin_unlock_irqrestore(&lock, flags);
	return 0;
}

static int function_read(struct counter_device *dev, struct counter_count *count, enum counter_function *f)
{
	*f = function[count->id];
	return 0;
}

static int function_write(struct counter_device *dev, struct counter_count *count, enum counter_function f)
{
	function[count->id] = f;
	return 0;
}

static int ceiling_read(struct counter_device *dev, struct counter_count *count, u64 *value)
{
	*value = ceiling[count->id];
	return 0;
}

static int ceiling_write(struct counter_device *dev, struct counter_count *count, u64 value)
{
	if (value != 65535 && value != U32_MAX)
		return -EINVAL;
	ceiling[count->id] = value;
	return 0;
}

static int enable_read(struct counter_device *dev, struct counter_count *count, u8 *value)
{
	*value = enabled[count->id];
	return 0;
}

static int enable_write(struct counter_device *dev, struct counter_count *count, u8 value)
{
	enabled[count->id] = value;
	return 0;
}

static int watch_validate(struct counter_device *dev, const struct counter_watch *watch)
{
	return watch->event == COUNTER_EVENT_CAPTURE && watch->channel == 0 ? 0 : -EINVAL;
}

static const struct counter_ops ops = {
	.count_read = count_read,
	.function_read = function_read,
	.function_write = function_write,
	.watch_validate = watch_validate,
};

static const enum counter_function functions[] = {
	COUNTER_FUNCTION_INCREASE,
	COUNTER_FUNCTION_QUADRATURE_X4,
};

static struct counter_comp extensions[] = {
	COUNTER_COMP_CEILING(ceiling_read, ceiling_write),
	COUNTER_COMP_ENABLE(enable_read, enable_write),
};

#define COUNT(n, label) { .id = n, .name = label, .functions_list = functions, \
	.num_functions = ARRAY_SIZE(functions), .ext = extensions, .num_ext = ARRAY_SIZE(extensions) }
static struct counter_count joints[] = { COUNT(0, "joint 1"), COUNT(1, "joint 2"), COUNT(2, "joint 3") };

/* ---------------------------------------------------------------- converter */

/* Called with the lock. */
static void take_frame(const u8 *frame)
{
	u8 reg = frame[0] >> 3 & 7, address = frame[0] & 7;
	u16 data = frame[1] << 8 | frame[2];
	int i;

	if (frame[0] & 0xc0) {	/* a read, or the bit that is always 0 */
		outputs.bad_frames++;
		return;
	}
	for (i = 0; i < OUTPUTS && reg < 2; i++) {
		if (address != i && address != 4)
			continue;
		if (reg == 0)
			waiting[i] = data;
		else
			outputs.range[i] = data;
	}
	if (reg == 2)
		outputs.power = data;
	if (reg == 3 && address == 5) {
		memcpy(outputs.word, waiting, sizeof(waiting));
		outputs.loads++;
		outputs.last_load_ns = ktime_get_ns();
	}
}

static int transfer_one_message(struct spi_controller *controller, struct spi_message *message)
{
	struct spi_transfer *transfer;
	bool mode_fits = (message->spi->mode & SPI_MODE_X_MASK) == SPI_MODE_1;
	unsigned long flags;
	bool ends;

	if (spi_error) {
		message->status = -spi_error;
		spi_finalize_current_message(controller);
		return 0;
	}
	spin_lock_irqsave(&lock, flags);
	list_for_each_entry(transfer, &message->transfers, transfer_list) {
		/* A frame is taken when its chip select ends. */
		ends = list_is_last(&transfer->transfer_list, &message->transfers) != transfer->cs_change;
		if (!mode_fits || !transfer->tx_buf || transfer->len != FRAME_BYTES || !ends)
			outputs.bad_frames++;
		else if (message->spi->chip_select == 0)
			take_frame(transfer->tx_buf);
		message->actual_length += transfer->len;
	}
	spin_unlock_irqrestore(&lock, flags);
	message->status = 0;
	spi_finalize_current_message(controller);
	return 0;
}

/* ----------------------------------------------------------------- heartbeat */

#define ONE_SHOT_NS (5 * NSEC_PER_MSEC)

static struct hrtimer one_shot_timer;
static int heartbeat_level;

static enum hrtimer_restart one_shot_ends(struct hrtimer *timer)
{
	WRITE_ONCE(one_shot, 0);
	return HRTIMER_NORESTART;
}

static void heartbeat_set(struct gpio_chip *chip, unsigned int offset, int level)
{
	if (level && !heartbeat_level) {
		WRITE_ONCE(one_shot, 1);
		hrtimer_start(&one_shot_timer, ns_to_ktime(ONE_SHOT_NS), HRTIMER_MODE_REL);
	}
	heartbeat_level = level;
}

static int heartbeat_get(struct gpio_chip *chip, unsigned int offset)
{
	return heartbeat_level;
}

static int heartbeat_direction(struct gpio_chip *chip, unsigned int offset)
{
	return GPIO_LINE_DIRECTION_OUT;
}

static int heartbeat_output(struct gpio_chip *chip, unsigned int offset, int level)
{
	heartbeat_set(chip, offset, level);
	return 0;
}

static const char *const heartbeat_names[] = { "HEARTBEAT" };
static struct gpio_chip heartbeat = {
	.label = "arm_hardware",
	.owner = THIS_MODULE,
	.base = -1,
	.ngpio = 1,
	.names = heartbeat_names,
	.get_direction = heartbeat_direction,
	.direction_output = heartbeat_output,
	.get = heartbeat_get,
	.set = heartbeat_set,
};

/* ---------------------------------------------------------------- the process */

static struct counter_device *counter;

static ssize_t arm_write(struct file *file, const char __user *data, size_t size, loff_t *at)
{
	struct arm_counts given;
	unsigned long flags;

	if (size != sizeof(given))
		return -EINVAL;
	if (copy_from_user(&given, data, size))
		return -EFAULT;
	spin_lock_irqsave(&lock, flags);
	counts = given;
	spin_unlock_irqrestore(&lock, flags);
	counter_push_event(counter, COUNTER_EVENT_CAPTURE, 0);
	return size;
}

static ssize_t arm_read(struct file *file, char __user *data, size_t size, loff_t *at)
{
	struct arm_outputs now;
	unsigned long flags;

	if (size != sizeof(now))
		return -EINVAL;
	spin_lock_irqsave(&lock, flags);
	now = outputs;
	spin_unlock_irqrestore(&lock, flags);
	return copy_to_user(data, &now, size) ? -EFAULT : size;
}

static const struct file_operations files = {
	.owner = THIS_MODULE,
	.read = arm_read,
	.write = arm_write,
};

static struct miscdevice process_end = {
	.minor = MISC_DYNAMIC_MINOR,
	.name = "arm_hardware",
	.fops = &files,
};

/* ------------------------------------------------------------------- set-up */

static struct platform_device *parent;
static struct spi_controller *controller;

static int __init start_counter(void)
{
	int error;

	counter = counter_alloc(0);
	if (!counter)
		return -ENOMEM;
	counter->name = "arm_hardware";
	counter->parent = &parent->dev;
	counter->ops = &ops;
	counter->counts = joints;
	counter->num_counts = ARRAY_SIZE(joints);
	error = counter_add(counter);
	if (error)
		counter_put(counter);
	return error;
}

static struct counter_device *units[JOINTS];

static void stop_units(void)
{
	int i;

	for (i = 0; i < JOINTS && units[i]; i++) {
		counter_unregister(units[i]);
		counter_put(units[i]);
	}
}

static int __init start_units(void)
{
	static const char *const names[JOINTS] = { "48300180.counter", "48302180.counter", "48304180.counter" };
	struct counter_device *unit;
	int i, error;

	for (i = 0; i < JOINTS && eqep; i++) {
		unit = counter_alloc(0);
		if (!unit)
			return -ENOMEM;
		unit->name = names[i];
		unit->parent = &parent->dev;
		unit->ops = &ops;
		unit->counts = &joints[i];
		unit->num_counts = 1;
		error = counter_add(unit);
		if (error) {
			counter_put(unit);
			return error;
		}
		units[i] = unit;
	}
	return 0;
}

static int __init start_spi(void)
{
	/* An id that spidev knows; the device behind it does not matter to it. */
	struct spi_board_info board = { .modalias = "dh2228fv", .max_speed_hz = 50000000, .bus_num = 0 };
	int error;

	controller = spi_alloc_master(&parent->dev, 0);
	if (!controller)
		return -ENOMEM;
	controller->bus_num = 0;
	controller->num_chipselect = CONVERTERS;
	controller->mode_bits = SPI_MODE_X_MASK;
	controller->bits_per_word_mask = SPI_BPW_MASK(8);
	controller->transfer_one_message = transfer_one_message;
	error = spi_register_controller(controller);
	if (error) {
		spi_controller_put(controller);
		return error;
	}
	for (; board.chip_select < CONVERTERS; board.chip_select++) {
		if (!spi_new_device(controller, &board)) {
			spi_unregister_controller(controller);
			return -ENODEV;
		}
	}
	return 0;
}

static int __init arm_init(void)
{
	int error;

	parent = platform_device_register_simple("arm_hardware", PLATFORM_DEVID_NONE, NULL, 0);
	if (IS_ERR(parent))
		return PTR_ERR(parent);
	error = start_counter();
	if (error)
		goto no_counter;
	error = start_units();
	if (error)
		goto no_spi;
	error = start_spi();
	if (error)
		goto no_spi;
	hrtimer_init(&one_shot_timer, CLOCK_MONOTONIC, HRTIMER_MODE_REL);
	one_shot_timer.function = one_shot_ends;
	heartbeat.parent = &parent->dev;
	error = gpiochip_add_data(&heartbeat, NULL);
	if (error)
		goto no_heartbeat;
	error = misc_register(&process_end);
	if (error)
		goto no_process;
	return 0;

no_process:
	gpiochip_remove(&heartbeat);
no_heartbeat:
	spi_unregister_controller(controller);
no_spi:
	stop_units();
	counter_unregister(counter);
	counter_put(counter);
no_counter:
	platform_device_unregister(parent);
	return error;
}

static void __exit arm_exit(void)
{
	misc_deregister(&process_end);
	gpiochip_remove(&heartbeat);
	hrtimer_cancel(&one_shot_timer);
	spi_unregister_controller(controller);
	stop_units();
	counter_unregister(counter);
	counter_put(counter);
	platform_device_unregister(parent);
}

module_init(arm_init);
module_exit(arm_exit);
MODULE_LICENSE("GPL");
MODULE_DESCRIPTION("Simulated counters and converter of a haptic arm");
MODULE_IMPORT_NS(COUNTER);
