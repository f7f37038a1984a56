// What units answer after a command that reads something, and what the driver makes of it. Units
// answer whatever is asked with what became of the last command in turn, its data too (firmware
// 0.10: Node::frame_reply(), Cpu::reply()).
#include "device/autd3/protocol/FrameQueue.h"
#include "tests/device/autd3/VirtualRehearsal.h"
#include "tests/device/autd3/emulator/UnitBench.h"

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <gtest/gtest.h>

using namespace midair::device;
using autd3::Command;
using autd3::FrameQueue;
using emulation::Bytes;
using emulation::UnitBench;

namespace
{

/// A command that reads something, and how many bytes.
struct Read
{
    const char* code;
    std::size_t bytes;
};
constexpr Read kReads[] = {{"E7", 1}, {"E8", 40}, {"EB", 8}, {"EC", 1}};

constexpr std::size_t kReplyAt = 4; ///< acknowledged number, result, flags, id, time
constexpr std::size_t kDataAt = 16;

Bytes dataOf(const Bytes& answer)
{
    return answer.size() < kDataAt ? Bytes() : Bytes(answer.begin() + kDataAt, answer.end());
}

autd3::FrameReply replyOf(const Bytes& answer)
{
    autd3::Answer read;
    std::string error;
    EXPECT_TRUE(autd3::readAnswer(answer, read, error)) << error;
    EXPECT_EQ(read.status, 0);
    return read.reply;
}

/// The driver's queue for one unit that is emulated; answers are kept until they are handed in.
class Conversation
{
public:
    Conversation()
    {
        bench.open();
        bench.askOne(0, "02 00 01 00 63 00"); // the queue begins at 0
    }
    /// Sends what is due; returns what comes back, oldest first.
    std::vector<Bytes> pump(double now_s, int skip = -1)
    {
        std::vector<Bytes> answers;
        int i = 0;
        queue.pump(now_s,
                   [&](const std::vector<std::uint8_t>& bytes)
                   {
                       if (i++ == skip) return true; // lost on its way
                       for (Bytes& answer : bench.ask(0, bytes))
                           answers.push_back(std::move(answer));
                       return true;
                   });
        return answers;
    }
    bool take(const Bytes& answer, double now_s = 0)
    {
        const auto number = static_cast<std::uint16_t>(answer.at(2) | (answer.at(3) << 8));
        return queue.take(replyOf(answer), number, now_s, done);
    }

    UnitBench bench;
    FrameQueue queue{100};
    std::vector<FrameQueue::Done> done;
};

} // namespace

TEST(Autd3Replies, a_read_is_answered_again_until_the_next_command_is_done)
{
    for (const Read& read : kReads)
    {
        UnitBench bench;
        bench.open();
        const int n = bench.next[0];
        const std::string frame = fmt::format("02 00 01 00 {:02X} {}", n, read.code);
        const Bytes first = bench.askOne(0, frame);
        const Bytes data = dataOf(first);
        ASSERT_EQ(data.size(), read.bytes) << read.code;
        const auto expectSame = [&](const std::string& sent, const char* what)
        {
            const Bytes answer = bench.askOne(0, sent);
            ASSERT_GE(answer.size(), kDataAt) << read.code << ", " << what;
            EXPECT_EQ(answer[kReplyAt], n) << read.code << ", " << what;
            EXPECT_EQ(answer[kReplyAt + 1], 0) << read.code << ", " << what;
            EXPECT_EQ(dataOf(answer), data) << read.code << ", " << what;
            EXPECT_EQ(replyOf(answer).data, data) << read.code << ", " << what;
        };
        expectSame("02 07 02 00", "a heartbeat");
        expectSame(frame, "a repeat");
        expectSame(fmt::format("02 00 03 00 {:02X} 04", n + 5), "out of turn");
        expectSame("02 07 04 00", "a heartbeat after what was out of turn");

        const Bytes refused = bench.askOne(0, fmt::format("02 00 05 00 {:02X} 60 07", n + 1));
        EXPECT_EQ(refused.at(kReplyAt + 1), 0x02);
        EXPECT_TRUE(dataOf(refused).empty());
        EXPECT_TRUE(dataOf(bench.askOne(0, "02 07 06 00")).empty());
        EXPECT_EQ(bench.askOne(0, "02 07 06 00").at(kReplyAt + 1), 0x02);

        bench.askOne(0, fmt::format("02 00 07 00 {:02X} {}", n + 2, read.code));
        const Bytes next = bench.askOne(0, fmt::format("02 00 08 00 {:02X} 04", n + 3));
        EXPECT_EQ(next.at(kReplyAt), n + 3);
        EXPECT_TRUE(dataOf(next).empty());

        bench.askOne(0, fmt::format("02 00 09 00 {:02X} {}", n + 4, read.code));
        for (const char* sent : {"02 00 0A 00 07 00", "02 00 0A 00 07 00", "02 07 0B 00"})
        {
            const Bytes reset = bench.askOne(0, sent);
            EXPECT_EQ(reset.at(kReplyAt), 0xFF) << sent;
            EXPECT_TRUE(dataOf(reset).empty()) << sent;
        }
    }
}

// Each read gets its own data, or none: whichever answer is lost, late or doubled.
TEST(Autd3Replies, data_go_to_the_command_that_has_read_them)
{
    const std::vector<std::pair<Command, std::size_t>> asked = {{Command::readFpgaState(), 1},
                                                                {Command::readTelemetry(), 40},
                                                                {Command::nop(), 0},
                                                                {Command::readFirmware(), 8}};
    std::vector<int> order = {0, 1, 2, 3};
    int complete = 0;
    do
        for (unsigned kept = 1; kept < 16; ++kept)
        {
            Conversation talk;
            for (const auto& one : asked)
                talk.queue.push(one.first);
            const std::vector<Bytes> answers = talk.pump(0);
            ASSERT_EQ(answers.size(), asked.size());
            for (const int i : order)
                for (int copy = 0; copy < 2 && (kept >> i & 1U) != 0; ++copy)
                    talk.take(answers[static_cast<std::size_t>(i)]);
            for (double now_s = 0.01; !talk.queue.isIdle() && now_s < 1; now_s += 0.05)
                for (const Bytes& answer : talk.pump(now_s))
                    talk.take(answer, now_s);
            ASSERT_EQ(talk.done.size(), asked.size());
            for (std::size_t i = 0; i < asked.size(); ++i)
            {
                const FrameQueue::Done& one = talk.done[i];
                EXPECT_EQ(one.code, asked[i].first.code());
                if (!one.result)
                {
                    EXPECT_TRUE(one.data.empty()) << "of another command";
                    continue;
                }
                EXPECT_EQ(one.result, std::uint8_t(0));
                EXPECT_EQ(one.data.size(), asked[i].second) << i << " of " << kept;
                ++complete;
            }
        }
    while (std::next_permutation(order.begin(), order.end()));
    EXPECT_GT(complete, 24 * 15); // the last one at least, each time
}

// What comes out of turn tells of the last one that was done, with its data.
TEST(Autd3Replies, an_answer_out_of_turn_settles_a_read_with_its_data)
{
    Conversation talk;
    talk.queue.push(Command::readFpgaState());
    talk.queue.push(Command::nop());
    talk.queue.push(Command::nop());
    const std::vector<Bytes> answers = talk.pump(0, 1); // the second is lost on its way
    ASSERT_EQ(answers.size(), 2u);
    EXPECT_TRUE(talk.take(answers[1]));
    ASSERT_EQ(talk.done.size(), 1u);
    EXPECT_EQ(talk.done[0].code, autd3::kReadFpgaStateCode);
    EXPECT_EQ(talk.done[0].data.size(), 1u);
    EXPECT_FALSE(talk.take(answers[0])); // settled by now
    for (const Bytes& answer : talk.pump(1))
        talk.take(answer, 1);
    EXPECT_TRUE(talk.queue.isIdle());
    EXPECT_EQ(talk.done.size(), 3u);
}

// Fields stand for ten seconds, units are asked for their state each second, and heartbeats go on.
TEST(Autd3Replies, a_still_field_is_held)
{
    for (const int units : {1, 2, 16})
        for (const bool isTimed : {true, false})
        {
            auto plan = VirtualRehearsal::planOf(units, isTimed, 3e-3);
            plan.fields_Hz = 0.1;
            plan.duration_s = 10;
            const auto outcome = VirtualRehearsal::play(plan);
            EXPECT_EQ(outcome.device.reconnects, 0u) << outcome.device.message;
            EXPECT_EQ(outcome.device.faults, 0u) << outcome.device.message;
            EXPECT_EQ(outcome.figures.refusals, 0u);
            EXPECT_EQ(outcome.device.played, 1u);
        }
}

// .. but a unit that is gone is missed, whatever its last answer had.
TEST(Autd3Replies, a_unit_that_is_lost_is_noticed)
{
    using emulation::ChainFaults;
    for (const auto kind :
         {ChainFaults::Kind::UNPLUG, ChainFaults::Kind::HANG, ChainFaults::Kind::REBOOT})
    {
        auto plan = VirtualRehearsal::planOf(2, true, 3e-3);
        plan.fields_Hz = 0.2;
        plan.duration_s = 4;
        plan.event = {0, kind, 1};
        plan.eventAfter_s = 2.5; // after states were asked for
        const auto outcome = VirtualRehearsal::play(plan);
        EXPECT_GE(outcome.device.faults, 1u);
        EXPECT_GT(outcome.lostAfter_s, 0);
        EXPECT_LT(outcome.lostAfter_s, 0.35) << int(kind);
        EXPECT_LE(outcome.silentAfter_s, 0.36) << int(kind);
    }
}
