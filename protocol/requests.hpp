// Which message answers which request, and which requests may be repeated when no answer came.
// Freestanding C++20, no heap.
#pragma once

#include "protocol/messages.hpp"

namespace umov::protocol {

/// What a host message is answered by.
template <class M>
struct AnswerTo;  // messages of the device, and streamed ones, have none

/// `repeatable`: carrying the request out twice has the effect of carrying it out once, so a host
/// whose answer got lost may simply ask again.
template <class ReplyMessage, bool is_repeatable>
struct Answer {
  using Reply = ReplyMessage;
  static constexpr bool repeatable = is_repeatable;
};

template <>
struct AnswerTo<Hello> : Answer<HelloReply, true> {};
template <>
struct AnswerTo<TimeSync> : Answer<TimeSyncReply, true> {};
template <>
struct AnswerTo<GetStatus> : Answer<Status, true> {};
template <>
struct AnswerTo<GetAxis> : Answer<AxisInfo, true> {};
template <>
struct AnswerTo<SetAxis> : Answer<AxisInfo, true> {};
template <>
struct AnswerTo<SetLockin> : Answer<Done, true> {};
template <>
struct AnswerTo<GetLockin> : Answer<LockinInfo, true> {};
template <>
struct AnswerTo<SaveSettings> : Answer<Done, true> {};
template <>
struct AnswerTo<ReadLog> : Answer<LogEntry, true> {};
template <>
struct AnswerTo<Stop> : Answer<Done, true> {};
// A second begin would throw away records, a second home or move would be refused while the first
// one runs, a second clear would find nothing to clear: ask for the status instead.
template <>
struct AnswerTo<ProgramBegin> : Answer<Done, false> {};
template <>
struct AnswerTo<ProgramControl> : Answer<Done, false> {};
template <>
struct AnswerTo<Home> : Answer<Done, false> {};
template <>
struct AnswerTo<Move> : Answer<Done, false> {};
template <>
struct AnswerTo<ClearFault> : Answer<Done, false> {};

/// Messages with an answer of their own; program_row and record_ack are streamed.
template <class M>
concept Request = requires {
  typename AnswerTo<M>::Reply;
};

template <Request M>
using ReplyTo = typename AnswerTo<M>::Reply;

}  // namespace umov::protocol
