// The independent watchdog: how long the program may hang, and when it may take longer.
#pragma once

namespace umov::boards::stm32f407 {

/// Starts the watchdog for a program that does not watch itself yet: 4 s (2.8 to 7.7 s, its clock
/// is coarse), enough for all that a start erases. The boot loader does so, once it has nothing to
/// erase any more. It cannot be stopped again.
void watch_start();

/// From here on the chip is reset unless fed within about 250 ms (170 to 470 ms).
void watch_main_loop();
void feed_watchdog();

/// While one lives the main loop need not come round for 4 s, if it was watched. For the erasure of
/// a flash sector, in which the processor stands still.
class LongWork {
 public:
  LongWork();
  ~LongWork();
  LongWork(const LongWork&) = delete;
  LongWork& operator=(const LongWork&) = delete;
};

}  // namespace umov::boards::stm32f407
