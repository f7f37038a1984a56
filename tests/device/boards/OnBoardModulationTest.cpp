// Modulations that are faster than a board's line carries fields: what sounds, by the bytes and
// their time on the wire, taken by models of the boards that were written from their firmware.
#include "device/boards/BoardCodec.h"
#include "device/boards/BoardDevice.h"
#include "device/boards/BoardKind.h"
#include "device/simulation/VirtualBoard.h"
#include "haptics/base/threads/SteadyClock.h"
#include "tests/Eventually.h"
#include "tests/device/boards/BoardTime.h"

#include <algorithm>
#include <complex>
#include <vector>

#include <gtest/gtest.h>

using namespace midair;
using namespace midair::device;

namespace
{

/// All emitters in phase: the focus is where they arrive alike.
DriveSignal loud(int transducers)
{
    DriveSignal signal;
    signal.phase.assign(static_cast<std::size_t>(transducers), 0);
    signal.duty.assign(static_cast<std::size_t>(transducers), 255);
    return signal;
}

DriveSignal off(int transducers)
{
    DriveSignal signal = loud(transducers);
    std::fill(signal.duty.begin(), signal.duty.end(), std::uint8_t(0));
    return signal;
}

/// The pressure where all emitters arrive alike, relative to full drive.
float atFocus(const std::vector<std::complex<float>>& q)
{
    std::complex<float> sum = 0;
    for (const std::complex<float>& one : q)
        sum += one;
    return std::abs(sum) / static_cast<float>(q.size());
}

/// What a board without a clock of its own sounds like, byte by byte.
Envelope envelopeOf(const std::vector<Sent>& sent, VirtualBoard& board)
{
    Envelope envelope;
    for (const Sent& one : sent)
    {
        // Only these change what sounds; the model takes a while to say what that is.
        const bool mayChange = one.byte == 253 || one.byte == 150 || one.byte == 151;
        board.receive(&one.byte, 1);
        if (mayChange) envelope.emplace_back(one.at_s, atFocus(board.playing()));
    }
    return envelope;
}

Envelope envelopeOfSketch(const std::vector<Sent>& sent, double until_s)
{
    Envelope envelope;
    Sketch sketch;
    std::size_t next = 0;
    for (double time_s = sent.front().at_s; time_s < until_s; time_s += 25e-6)
    {
        for (; next < sent.size() && sent[next].at_s <= time_s; ++next)
            sketch.give(sent[next].byte);
        const float sounds = sketch.turn();
        if (envelope.empty() || envelope.back().second != sounds)
            envelope.emplace_back(time_s, sounds);
    }
    return envelope;
}

/// A board of a kind at the end of a wire.
struct Bench
{
    explicit Bench(const std::string& kind, int transducers) :
        wire(makeBoardCodec(kind)->bytesPerSecond()),
        device(kind + ":",
               makeBoardCodec(kind),
               transducers,
               [this](const std::vector<std::uint8_t>&)
               { return std::make_unique<WireSink>(wire); })
    {
    }
    Wire wire;
    BoardDevice device;
};

DriveSequence halves(int transducers, double frequency_Hz)
{
    return {{loud(transducers), off(transducers)}, 2 * frequency_Hz};
}

} // namespace

// Looked at while the line never ran dry: a busy machine may not wake a thread every 45 ms.
TEST(OnBoardModulation, SonicSurfaceSwapsAtTheFrequencyAsked)
{
    for (const double frequency_Hz : {60.0, 200.0, 437.0})
    {
        double depth = 0;
        double strongest_Hz = 0;
        double whole_s = 0;
        for (int attempt = 0; attempt < 20 && whole_s < 0.5; ++attempt)
        {
            Bench bench("sonicsurface", 256);
            ASSERT_TRUE(bench.device.sendSequence(halves(256, frequency_Hz)));
            letPass(2.4);
            const auto board = makeVirtualBoard("sonicsurface", 256);
            const std::vector<Sent> sent = bench.wire.sent();
            const auto [begin_s, end_s] =
                longestBusy(sent, makeBoardCodec("sonicsurface")->bytesPerSecond());
            whole_s = std::min(end_s - begin_s - 0.1, 2.0); // without the start
            const Spectrum spectrum(envelopeOf(sent, *board), end_s - whole_s, end_s);
            depth = spectrum.depth(frequency_Hz);
            strongest_Hz = spectrum.strongest_Hz();
            EXPECT_LT(bench.wire.mostAhead_s(), 0.1) << "what a silence has to overtake";
        }
        EXPECT_GE(whole_s, 0.5);
        RecordProperty("depth at " + std::to_string(frequency_Hz), std::to_string(depth));
        EXPECT_NEAR(strongest_Hz, frequency_Hz, 1.0);
        EXPECT_GT(depth, 0.9) << frequency_Hz;
    }
}

// The same without a clock: each call for more bytes comes up to 40 ms after the last one.
TEST(OnBoardModulation, SwapsKeepTheTimeOfTheLineHoweverTheyAreAskedFor)
{
    const auto codec = makeBoardCodec("sonicsurface");
    const double byte_s = 1 / codec->bytesPerSecond();
    BufferSwaps swaps(*codec, halves(256, 200.0));
    std::vector<std::uint8_t> bytes;
    swaps.appendStart(bytes);
    double line_s = static_cast<double>(bytes.size()) * byte_s;
    swaps.begin(line_s);
    unsigned int random = 1;
    for (int k = 0; line_s < 2.5; ++k)
    {
        random = random * 1103515245 + 12345;
        if (k % 25 == 0) swaps.refresh();
        const std::size_t before = bytes.size();
        swaps.append(bytes, line_s, line_s + 0.04 * (random >> 16 & 0x7FFF) / 32768.0);
        line_s += static_cast<double>(bytes.size() - before) * byte_s;
    }
    std::vector<Sent> sent;
    for (const std::uint8_t byte : bytes)
        sent.push_back({static_cast<double>(sent.size() + 1) * byte_s, byte});
    const auto board = makeVirtualBoard("sonicsurface", 256);
    const Spectrum spectrum(envelopeOf(sent, *board), 0.4, 2.4);
    EXPECT_NEAR(spectrum.strongest_Hz(), 200.0, 0.3);
    EXPECT_GT(spectrum.depth(200.0), 1.1); // 4/pi for halves, less what writing the buffers takes
}

TEST(OnBoardModulation, UltrainoTimesItByItself)
{
    for (const double frequency_Hz : {80.0, 200.0, 400.0})
    {
        Bench bench("ultraino", 64);
        DriveSequence sequence{{}, 4 * frequency_Hz};
        for (const int duty : {255, 85, 0, 85}) // the top, half of the power, nothing
        {
            sequence.signals.push_back(loud(64));
            std::fill(sequence.signals.back().duty.begin(),
                      sequence.signals.back().duty.end(),
                      static_cast<std::uint8_t>(duty));
        }
        ASSERT_TRUE(bench.device.sendSequence(sequence));
        letPass(2.4);
        const double end_s = base::steadySeconds();
        const std::vector<Sent> sent = bench.wire.sent();
        const Spectrum spectrum(envelopeOfSketch(sent, end_s), end_s - 2.0, end_s);
        EXPECT_NEAR(spectrum.strongest_Hz(), frequency_Hz, 1.0);
        EXPECT_GT(spectrum.depth(frequency_Hz), 0.9) << frequency_Hz;
    }
}

// Silence, and a field after it, in the middle of a modulation; the board's other buffer, too.
TEST(OnBoardModulation, SilenceOvertakesIt)
{
    for (const char* kind : {"sonicsurface", "ultraino"})
    {
        const bool isMega = kind == std::string("ultraino");
        const int count = isMega ? 64 : 256;
        Bench bench(kind, count);
        ASSERT_TRUE(bench.device.sendSequence(halves(count, 200.0)));
        letPass(0.5);
        const double asked_s = base::steadySeconds();
        bench.device.silence();
        letPass(0.4);
        std::vector<Sent> sent = bench.wire.sent();
        const auto board = makeVirtualBoard(kind, count);
        const Envelope envelope =
            isMega ? envelopeOfSketch(sent, base::steadySeconds()) : envelopeOf(sent, *board);
        EXPECT_EQ(envelope.back().second, 0.0F);
        double lastSound_s = 0;
        for (std::size_t i = 0; i + 1 < envelope.size(); ++i)
            if (envelope[i].second > 0) lastSound_s = envelope[i + 1].first;
        EXPECT_LT(lastSound_s - asked_s, isMega ? 0.12 : 0.05) << kind;
        EXPECT_EQ(atFocus(bench.device.played()), 0.0F);
        // A swap that nobody asked for brings nothing back.
        sent.push_back({base::steadySeconds(), std::uint8_t(isMega ? 0 : 253)});
        board->powerUp();
        for (const Sent& one : sent)
            board->receive(&one.byte, 1);
        EXPECT_EQ(atFocus(board->playing()), 0.0F) << kind;

        ASSERT_TRUE(bench.device.send(loud(count)));
        letPass(0.4);
        const auto after = bench.wire.sent();
        board->powerUp();
        for (const Sent& one : after)
            board->receive(&one.byte, 1);
        EXPECT_GT(atFocus(board->playing()), 0.9F) << kind;
        const Envelope steady =
            isMega ? envelopeOfSketch(after, base::steadySeconds()) : envelopeOf(after, *board);
        EXPECT_GT(steady.back().second, 0.9F) << kind << ": without what was stored";
    }
}

TEST(OnBoardModulation, AFieldInItsPlaceIsSteady)
{
    for (const char* kind : {"sonicsurface", "ultraino"})
    {
        const bool isMega = kind == std::string("ultraino");
        const int count = isMega ? 64 : 256;
        Bench bench(kind, count);
        ASSERT_TRUE(bench.device.sendSequence(halves(count, 200.0)));
        letPass(0.4);
        ASSERT_TRUE(bench.device.send(loud(count)));
        letPass(1.2);
        const auto sent = bench.wire.sent();
        const double end_s = sent.back().at_s;
        const auto board = makeVirtualBoard(kind, count);
        const Envelope envelope = isMega ? envelopeOfSketch(sent, end_s) : envelopeOf(sent, *board);
        for (const auto& [since_s, pressure] : envelope)
        {
            if (since_s < end_s - 0.8) continue;
            EXPECT_GT(pressure, 0.9F) << kind;
        }
        EXPECT_GT(envelope.back().second, 0.9F) << kind;
    }
}

// Fields of a moving object: the modulation goes on, and the last one sounds.
TEST(OnBoardModulation, NewFieldsKeepItsFrequency)
{
    Bench bench("sonicsurface", 256);
    DriveSequence sequence = halves(256, 200.0);
    const double begin_s = base::steadySeconds();
    for (int k = 0; base::steadySeconds() - begin_s < 2.4; ++k)
    {
        // All in phase, whatever the phase.
        std::fill(sequence.signals[0].phase.begin(),
                  sequence.signals[0].phase.end(),
                  static_cast<std::uint8_t>(8 * k));
        // It begins where the host is in its period.
        DriveSequence now = sequence;
        std::rotate(now.signals.begin(), now.signals.begin() + k % 2, now.signals.end());
        EXPECT_TRUE(bench.device.sendSequence(now));
        letPass(0.025);
    }
    letPass(0.4);
    const auto board = makeVirtualBoard("sonicsurface", 256);
    const std::vector<Sent> sent = bench.wire.sent();
    const double end_s = sent.back().at_s - 0.4;
    const Spectrum spectrum(envelopeOf(sent, *board), end_s - 2.0, end_s);
    EXPECT_NEAR(spectrum.strongest_Hz(), 200.0, 1.0);
    EXPECT_GT(spectrum.depth(200.0), 0.8);
    const DeviceReport report = bench.device.report();
    EXPECT_EQ(report.sent, report.played + report.dropped + report.pending);
    EXPECT_GT(report.played, 15U);
    // The phase of the last one is in a buffer of the board.
    std::vector<std::complex<float>> wanted;
    makeBoardCodec("sonicsurface")->played(sequence.signals[0], wanted);
    const std::uint8_t swap = 253;
    bool isThere = false;
    for (int buffer = 0; buffer < 2; ++buffer, board->receive(&swap, 1))
        isThere = isThere || std::abs(board->playing()[7] - wanted[7]) < 1e-3F;
    EXPECT_TRUE(isThere);
}

// Of a sequence that takes half a second to write: silence and fields come after the piece that is
// on the line, and what was written of it doesn't come back.
TEST(OnBoardModulation, AnUploadIsGivenUpForWhatIsNewer)
{
    DriveSequence sequence{{}, 800.0};
    for (int k = 0; k < 32; ++k)
    {
        sequence.signals.push_back(loud(64));
        std::fill(sequence.signals.back().phase.begin(),
                  sequence.signals.back().phase.end(),
                  static_cast<std::uint8_t>(8 * k));
    }
    for (const double after_s : {0.01, 0.2, 0.53})
    {
        Bench bench("ultraino", 64);
        ASSERT_TRUE(bench.device.sendSequence(sequence));
        letPass(after_s);
        double asked_s = base::steadySeconds();
        bench.device.silence();
        letPass(0.3);
        std::vector<Sent> sent = bench.wire.sent();
        Envelope envelope = envelopeOfSketch(sent, base::steadySeconds());
        double lastSound_s = 0;
        for (std::size_t i = 0; i + 1 < envelope.size(); ++i)
            if (envelope[i].second > 0) lastSound_s = envelope[i + 1].first;
        EXPECT_EQ(envelope.back().second, 0.0F) << after_s;
        EXPECT_LT(lastSound_s - asked_s, 0.12) << after_s;
        sent.push_back({base::steadySeconds(), 0});
        EXPECT_EQ(envelopeOfSketch(sent, base::steadySeconds() + 0.01).back().second, 0.0F)
            << "a swap that nobody asked for brings nothing back";
        DeviceReport report = bench.device.report();
        EXPECT_EQ(report.sent, 1U);
        EXPECT_EQ(report.played + report.dropped, 1U);

        ASSERT_TRUE(bench.device.sendSequence(sequence));
        letPass(after_s);
        asked_s = base::steadySeconds();
        DriveSignal half = loud(64);
        std::fill(half.duty.begin(), half.duty.end(), std::uint8_t(85));
        ASSERT_TRUE(bench.device.send(half));
        letPass(0.3);
        envelope = envelopeOfSketch(bench.wire.sent(), base::steadySeconds());
        EXPECT_NEAR(envelope.back().second, 0.58F, 0.02F) << after_s;
        EXPECT_LT(envelope.back().first - asked_s, 0.12) << after_s;
        report = bench.device.report();
        EXPECT_EQ(report.sent, 3U);
        EXPECT_EQ(report.played + report.dropped, 3U);

        ASSERT_TRUE(bench.device.sendSequence(sequence));
        letPass(after_s);
        ASSERT_TRUE(bench.device.sendSequence(halves(64, 200.0)));
        letPass(1.2);
        const double end_s = base::steadySeconds();
        const Spectrum spectrum(envelopeOfSketch(bench.wire.sent(), end_s), end_s - 0.8, end_s);
        EXPECT_NEAR(spectrum.strongest_Hz(), 200.0, 1.5) << after_s;
    }
}

TEST(OnBoardModulation, WhatABoardCantTimeIsRefused)
{
    Bench surface("sonicsurface", 256);
    DriveSequence three = halves(256, 100.0);
    EXPECT_FALSE(surface.device.sendSequence({{loud(255), off(255)}, 400.0}));
    three.signals.push_back(loud(256));
    three.signals.back().phase[3] = 128;
    EXPECT_FALSE(surface.device.sendSequence(three));
    Bench mega("ultraino", 64);
    EXPECT_FALSE(mega.device.sendSequence(halves(64, 0.5))) << "each lasts 40,000 periods";
    EXPECT_TRUE(mega.device.sendSequence(halves(64, 10.0)));
    EXPECT_EQ(mega.device.report().refused, 1U);
    EXPECT_EQ(surface.device.report().refused, 2U);
}

TEST(OnBoardModulation, ASimulatedBoardPlaysItToo)
{
    for (const auto& [kind, count] : {std::pair("sonicsurface", 256), std::pair("ultraino", 64)})
    {
        const auto device = openDevice(std::string("sim:?board=") + kind, {count, {}});
        ASSERT_TRUE(device->sendSequence(halves(count, 200.0))) << kind;
        letPass(0.15);
        const double now_s = base::steadySeconds();
        const std::vector<PlayedField> fields = device->playedSince(now_s - 0.08);
        EXPECT_NEAR(static_cast<double>(fields.size()), 0.08 * 400, 2.0) << kind;
        for (std::size_t i = 0; i + 1 < fields.size(); ++i)
        {
            EXPECT_NEAR(fields[i + 1].since_s - fields[i].since_s, 2.5e-3, 1e-9);
            EXPECT_NEAR(atFocus(fields[i].q) + atFocus(fields[i + 1].q), 1.0, 1e-3);
        }
        device->silence();
        letPass(0.02);
        EXPECT_EQ(atFocus(device->played()), 0.0F) << kind;
        ASSERT_TRUE(device->sendSequence(halves(count, 200.0)));
        ASSERT_TRUE(device->send(loud(count)));
        letPass(0.02);
        EXPECT_GT(atFocus(device->played()), 0.9F) << kind;
    }
}
