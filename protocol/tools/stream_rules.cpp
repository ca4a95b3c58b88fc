// The behaviour both ends must keep to, in prose.
#include "protocol/tools/description.hpp"

namespace umov::protocol {

std::string describe_session_and_streams() {
  return R"(## Session

1. The host sends one byte 0, which ends whatever a crashed predecessor left half-sent, and then `hello`.
   It drops everything it receives until the `hello_reply` that carries the sequence number of its `hello`.
2. The device answers `hello` with `hello_reply` always, also when the host's version or schema hash differs:
   so the host can name both. The first ten bytes of `hello` and `hello_reply` (version, hash) are the same in
   every version. When they differ the session stays closed and the device refuses every other request with
   `schema_mismatch`, as it does before the first `hello`.
3. `hello` on a pipe whose session is open opens it anew: the host was restarted. Program, rows and records
   in the device stay as they are.
4. A pipe that serves one host at a time answers the `hello` of a second one with `busy` (its number, or 0)
   and goes on with the first.
5. A request carries the next number of the host's counter; its reply, `done` or `error_reply` carries the same
   number. Frames the device sends of its own accord (`row_credit`, `record`, `fault_event`) carry the device's
   own counter, which says nothing about their order.
6. Frames may be lost, repeated or swapped by any pipe. The device acts on every request it gets; the host
   therefore asks again only where acting twice does no harm: `hello`, `time_sync`, `get_status`, `get_axis`,
   `set_axis`, `set_lockin`, `get_lockin`, `save_settings`, `read_log`, `stop`. When any other request goes unanswered the host finds out by
   `get_status` what became of it.
7. The host sends something at least every 500 ms of its clock (`get_status` when there is nothing else). A
   device that hears nothing for its board's link timeout (2 s or more) while it moves or shines may latch
   `link_lost`; the host that resumes the program clears that one fault itself, every other fault is left to
   the user.

## Rows: credit

1. `program_begin` names the program, its first row and its length; the device forgets rows and records of any
   earlier program. It is refused with `wrong_state` while a program is running, waiting or paused: end that
   one first (`program_control` 2).
2. The device then says by `row_credit` which row it wants next and how many fit. The host sends rows
   `next_row` … `next_row + free_slots - 1`, in order, each once.
3. The device takes a row only if it is the wanted one and there is room; others are ignored. It sends
   `row_credit` after `program_begin` and after rows have arrived, taken or ignored (one for all of a batch),
   and when room has been made (it may wait until a quarter of its buffer is free). While it waits for rows it
   repeats the credit every 100 ms.
4. A host that sees no progress of `next_row` for half a second sends again from the last `next_row`, one row even
   when its credit is used up: the answer, taken or ignored, brings it up to date.
5. A row the device can't carry out (position outside the limits, field out of range) is refused by
   `error_reply` with that frame's sequence number; the program then waits with that row still wanted.
6. A `row_credit` or row of another program is ignored.

## Records: acknowledgement

1. Each row gives one record with the row's index. The device sends it when it is measured and keeps it until
   it is acknowledged. With its ring full it pauses (`waiting_for_host`); it never drops one.
2. `record_ack` says that all records below `next_index` are safe on disk. `next_index` above
   `first_unacknowledged`: the device forgets those below. Equal to it: the device sends all it holds again,
   from `next_index` on, at once (this is how the host asks for what it misses). Below it, above
   `next_record`, or of another program: ignored.
3. The host asks for records that don't arrive; it sees what it misses by gaps in the index and by
   `next_record` in `status`. A device may also repeat unacknowledged records of its own accord, not more often
   than once a second: a host may take several seconds to make a batch safe.
4. The host hands records on in order of index, each once, and drops the others. It acknowledges when they are
   safe, in batches if it likes, but at the latest when the device is `waiting_for_host`.
5. The program is complete when `first_unacknowledged` equals `row_count`. The device then is `idle` and
   still names the program in `status` until another one begins.
6. After an abort (`program_control` 2), or a fault, records not yet acknowledged stay available and are sent
   as above.

## Resuming

After `hello` the host asks for the status. If `program_id` is its own, the program is not at rest, and the
first record it misses lies between `first_unacknowledged` and `next_record`, it goes on: it acknowledges what it
has (which makes the device send the rest), resumes a paused program, and feeds rows from `next_row`. Otherwise
it first fetches what records of its program the device still holds, ends the program there and begins its own
at the first record it misses. Rows measured twice in that case give the record of the second measurement.
)";
}

}  // namespace umov::protocol
