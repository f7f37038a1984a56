#include "device/autd3/protocol/FrameQueue.h"

#include <algorithm>
#include <random>
#include <vector>

#include <gtest/gtest.h>

using namespace midair::device::autd3;

namespace
{

/// A unit as far as numbers go: does frames in turn, and answers.
class InTurn
{
public:
    /// Returns the answer to a frame; nothing for a copy of the last one that isn't a repeat.
    FrameReply take(const std::vector<std::uint8_t>& frame)
    {
        const std::uint8_t sequence = frame[4];
        if (sequence == static_cast<std::uint8_t>(_acknowledged + 1))
        {
            _acknowledged = sequence;
            done.push_back(frame[5]);
        }
        FrameReply reply;
        reply.acknowledged = _acknowledged;
        reply.flags = HAS_ID;
        reply.id = 0;
        return reply;
    }
    std::vector<std::uint8_t> done; ///< the commands, in the order in which they were done

private:
    std::uint8_t _acknowledged = 0xFF;
};

std::uint16_t numberOf(const std::vector<std::uint8_t>& frame)
{
    return static_cast<std::uint16_t>(frame[2] | (frame[3] << 8));
}

/// Collects what a queue sends.
struct Wire
{
    std::vector<std::vector<std::uint8_t>> frames;
    FrameQueue::Send send = [this](const std::vector<std::uint8_t>& bytes)
    {
        frames.push_back(bytes);
        return true;
    };
};

/// Sends a first command, which isn't answered until 8 ms later.
void answerAfter8ms(FrameQueue& queue, Wire& wire)
{
    InTurn unit;
    std::vector<FrameQueue::Done> done;
    queue.push(Command::readFpgaState());
    queue.pump(0, wire.send);
    EXPECT_NEAR(queue.due_s(99), 2e-3, 1e-9);
    EXPECT_TRUE(queue.take(unit.take(wire.frames[0]), numberOf(wire.frames[0]), 8e-3, done));
}

} // namespace

TEST(Autd3FrameQueue, keeps_at_most_seven_in_flight)
{
    FrameQueue queue;
    Wire wire;
    for (int i = 0; i < 20; ++i)
        queue.push(Command::nop());
    queue.pump(0, wire.send);
    EXPECT_EQ(wire.frames.size(), 7u);
    EXPECT_EQ(queue.inFlight(), 7u);
    EXPECT_EQ(queue.unsent(), 13u);
    InTurn unit;
    std::vector<FrameQueue::Done> done;
    ASSERT_TRUE(queue.take(unit.take(wire.frames[0]), numberOf(wire.frames[0]), 0, done));
    EXPECT_EQ(done.size(), 1u);
    queue.pump(0, wire.send);
    EXPECT_EQ(wire.frames.size(), 8u);
    EXPECT_EQ(wire.frames[7][4], 7); // numbers follow each other
}

TEST(Autd3FrameQueue, repeats_the_same_bytes_until_it_is_acknowledged)
{
    FrameQueue queue;
    Wire wire;
    queue.push(Command::clear());
    queue.pump(0, wire.send);
    queue.pump(1e-3, wire.send);
    EXPECT_EQ(wire.frames.size(), 1u);
    EXPECT_NEAR(queue.due_s(9), FrameQueue::kRepeat_s, 1e-9);
    queue.pump(FrameQueue::kRepeat_s, wire.send);
    ASSERT_EQ(wire.frames.size(), 2u);
    EXPECT_EQ(wire.frames[1], wire.frames[0]);
    EXPECT_EQ(queue.repeats(), 1u);
    EXPECT_EQ(queue.oldest_s(9), 0);
}

TEST(Autd3FrameQueue, goes_on_from_what_the_unit_did_last)
{
    FrameQueue queue;
    Wire wire;
    InTurn unit;
    std::vector<FrameQueue::Done> done;
    for (const Command& command : {Command::clear(), Command::synchronize(), Command::nop()})
        queue.push(command);
    queue.pump(0, wire.send);
    queue.take(unit.take(wire.frames[0]), numberOf(wire.frames[0]), 0, done);
    // The second is lost; the third is out of turn.
    EXPECT_TRUE(queue.take(unit.take(wire.frames[2]), numberOf(wire.frames[2]), 0, done));
    EXPECT_EQ(done.size(), 1u);
    queue.pump(1e-3, wire.send); // sooner than a repeat
    ASSERT_EQ(wire.frames.size(), 5u);
    EXPECT_EQ(wire.frames[3], wire.frames[1]);
    EXPECT_EQ(wire.frames[4], wire.frames[2]);
}

TEST(Autd3FrameQueue, tells_that_a_result_is_not_known)
{
    FrameQueue queue;
    Wire wire;
    InTurn unit;
    std::vector<FrameQueue::Done> done;
    queue.push(Command::clear());
    queue.push(Command::nop());
    queue.pump(0, wire.send);
    unit.take(wire.frames[0]); // its answer is lost
    FrameReply reply = unit.take(wire.frames[1]);
    reply.result = 0x07;
    queue.take(reply, numberOf(wire.frames[1]), 0, done);
    ASSERT_EQ(done.size(), 2u);
    EXPECT_FALSE(done[0].result.has_value());
    EXPECT_EQ(done[1].result, 0x07);
    EXPECT_TRUE(queue.isIdle());
}

TEST(Autd3FrameQueue, takes_no_answer_to_what_is_not_in_flight)
{
    FrameQueue queue(100);
    Wire wire;
    InTurn unit;
    std::vector<FrameQueue::Done> done;
    queue.push(Command::nop());
    queue.pump(0, wire.send);
    const FrameReply reply = unit.take(wire.frames[0]);
    EXPECT_FALSE(queue.take(reply, 99, 0, done));
    EXPECT_TRUE(queue.take(reply, 100, 0, done));
    EXPECT_FALSE(queue.take(reply, 100, 0, done)); // a copy
    EXPECT_EQ(done.size(), 1u);
}

TEST(Autd3FrameQueue, an_old_or_a_mad_acknowledgement_settles_nothing)
{
    FrameQueue queue;
    Wire wire;
    std::vector<FrameQueue::Done> done;
    for (int i = 0; i < 3; ++i)
        queue.push(Command::nop());
    queue.pump(0, wire.send);
    FrameReply reply;
    for (const int acknowledged : {3, 100, 255, 250})
    {
        reply.acknowledged = static_cast<std::uint8_t>(acknowledged);
        EXPECT_TRUE(queue.take(reply, numberOf(wire.frames[1]), 0, done));
        EXPECT_TRUE(done.empty()) << acknowledged;
    }
    EXPECT_EQ(queue.inFlight(), 3u);
}

TEST(Autd3FrameQueue, what_could_not_be_sent_is_sent_later)
{
    FrameQueue queue;
    queue.push(Command::nop());
    EXPECT_FALSE(queue.pump(0, [](const std::vector<std::uint8_t>&) { return false; }));
    EXPECT_EQ(queue.unsent(), 1u);
    Wire wire;
    EXPECT_TRUE(queue.pump(0, wire.send));
    EXPECT_EQ(wire.frames.front()[4], 0); // no number is left out
}

TEST(Autd3FrameQueue, drops_writes_that_were_not_sent)
{
    FrameQueue queue;
    Wire wire;
    const UnitPattern pattern;
    for (int i = 0; i < 8; ++i)
        queue.push(Command::nop());
    queue.push(Command::writeRaw(0, 0, {&pattern}));
    queue.push(Command::silenceAll());
    queue.push(Command::configureBank(0, {}));
    queue.pump(0, wire.send);
    EXPECT_EQ(queue.dropUnsentWrites(), 2);
    EXPECT_EQ(queue.unsent(), 2u);
}

// Whatever is lost, doubled or swapped on the way: all commands are done once, and in turn.
TEST(Autd3FrameQueue, does_all_once_and_in_turn_on_a_bad_network)
{
    std::mt19937 random(7);
    const auto chance = [&](double p)
    { return std::uniform_real_distribution<>(0, 1)(random) < p; };
    FrameQueue queue;
    InTurn unit;
    std::vector<FrameQueue::Done> done;
    constexpr int kCommands = 2000; // more than there are numbers
    std::vector<std::uint8_t> wanted;
    for (int i = 0; i < kCommands; ++i)
    {
        const Command command = i % 3 == 0 ? Command::nop() : Command::clear();
        wanted.push_back(command.code());
        queue.push(command);
    }
    double now_s = 0;
    for (; !queue.isIdle() && now_s < 100; now_s += 0.5e-3)
    {
        Wire wire;
        queue.pump(now_s, wire.send);
        std::vector<std::vector<std::uint8_t>> arrived;
        for (const auto& frame : wire.frames)
            for (int copies = chance(0.1) ? 0 : chance(0.1) ? 2 : 1; copies > 0; --copies)
                arrived.push_back(frame);
        if (chance(0.2)) std::shuffle(arrived.begin(), arrived.end(), random);
        for (const auto& frame : arrived)
        {
            const FrameReply reply = unit.take(frame);
            if (!chance(0.1)) queue.take(reply, numberOf(frame), 0, done);
        }
    }
    EXPECT_TRUE(queue.isIdle());
    EXPECT_EQ(unit.done, wanted);
    EXPECT_EQ(done.size(), wanted.size());
    EXPECT_GT(queue.repeats(), 0u);
}

TEST(Autd3FrameQueue, sends_copies_of_what_must_arrive)
{
    FrameQueue queue;
    Wire wire;
    queue.push(Command::activateBank(0, SwitchMode::AT_ONCE), 1e-3, 2);
    queue.push(Command::readFpgaState());
    queue.pump(0, wire.send);
    ASSERT_EQ(wire.frames.size(), 3u);
    EXPECT_EQ(wire.frames[0], wire.frames[1]);
    EXPECT_EQ(queue.inFlight(), 2u);
    EXPECT_EQ(queue.repeats(), 0u);
    InTurn unit;
    std::vector<FrameQueue::Done> done;
    EXPECT_TRUE(queue.take(unit.take(wire.frames[0]), numberOf(wire.frames[0]), 0, done));
    EXPECT_FALSE(queue.take(unit.take(wire.frames[1]), numberOf(wire.frames[1]), 0, done));
    EXPECT_TRUE(queue.take(unit.take(wire.frames[2]), numberOf(wire.frames[2]), 0, done));
    EXPECT_EQ(done.size(), 2u);
    EXPECT_EQ(unit.done.size(), 2u);
}

TEST(Autd3FrameQueue, waits_longer_where_answers_take_long)
{
    FrameQueue queue;
    Wire wire;
    answerAfter8ms(queue, wire);
    queue.push(Command::readFpgaState());
    queue.pump(1, wire.send);
    EXPECT_NEAR(queue.due_s(99), 1 + 1.5 * 8e-3, 1e-9);
    // What is repeated in vain is repeated less often.
    double now_s = 1;
    std::vector<double> pauses_s;
    for (int i = 0; i < 4; ++i)
    {
        const double due_s = queue.due_s(99);
        pauses_s.push_back(due_s - now_s);
        queue.pump(now_s = due_s, wire.send);
    }
    EXPECT_NEAR(pauses_s[1], 24e-3, 1e-9);
    EXPECT_NEAR(pauses_s[3], 30e-3, 1e-9);
    EXPECT_EQ(queue.repeats(), 4u);
}

TEST(Autd3FrameQueue, a_switch_is_repeated_as_soon_as_it_is_asked_for)
{
    FrameQueue queue;
    Wire wire;
    answerAfter8ms(queue, wire);
    queue.push(Command::activateBank(0, SwitchMode::AT_ONCE), 0.3e-3);
    queue.pump(1, wire.send);
    for (int i = 1; i < 5; ++i)
    {
        EXPECT_NEAR(queue.due_s(99), 1 + i * 0.3e-3, 1e-9);
        queue.pump(queue.due_s(99), wire.send);
    }
}
