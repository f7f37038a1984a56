// What hands take that come by OSC over UDP on this machine: from the call that sends two of them
// to the moment when a hand source has them, at 250 Hz; quiet, and beside a flood of nonsense.

#include "engine-bridge/hands/osc/OscReceiver.h"
#include "engine-bridge/hands/osc/OscSender.h"
#include "haptics/base/Percentile.h"
#include "haptics/base/threads/SteadyClock.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <string>
#include <thread>
#include <vector>

#include <CLI/CLI.hpp>
#include <sys/socket.h>
#include <unistd.h>

using namespace midair;

namespace
{

struct Settings
{
    double seconds = 10.0;
    double rate_Hz = 250.0;
};

/// Two hands whose index fingers' tips say, by their places, which ones they are.
std::vector<bridge::Hand> twoHands(long number)
{
    const Eigen::Vector3d tip(1e-4 * static_cast<double>(number % 5000), 0.0, 0.2);
    return {bridge::openHandWithIndexTipAt(0, tip, Eigen::Quaterniond::Identity()),
            bridge::openHandWithIndexTipAt(1, tip, Eigen::Quaterniond::Identity())};
}

/// Sends to the port as often as it is told; 0: never.
class Flood
{
public:
    Flood(int port, double rate_Hz) : _thread([this, port, rate_Hz] { run(port, rate_Hz); }) {}
    ~Flood()
    {
        _stop = true;
        _thread.join();
    }
    Flood(const Flood&) = delete;
    Flood& operator=(const Flood&) = delete;

private:
    void run(int port, double rate_Hz) const
    {
        if (!(rate_Hz > 0.0)) return;
        const bridge::SocketAddress to = bridge::SocketAddress::parse("127.0.0.1", port);
        const int socket = ::socket(AF_INET, SOCK_DGRAM, 0);
        const std::string bytes(1200, 'x');
        const auto begin = std::chrono::steady_clock::now();
        for (long k = 0; !_stop; ++k)
        {
            if (k % 10 == 0)
                std::this_thread::sleep_until(
                    begin + std::chrono::duration_cast<std::chrono::nanoseconds>(
                                std::chrono::duration<double>(static_cast<double>(k) / rate_Hz)));
            ::sendto(socket, bytes.data(), bytes.size(), MSG_DONTWAIT, to.get(), to.size());
        }
        ::close(socket);
    }

    std::atomic<bool> _stop{false};
    std::thread _thread;
};

/// Calls \a send at the rate and waits, as long as a hand isn't lost, until \a isThere; returns the
/// times between in us.
template<typename Send, typename IsThere>
std::vector<double> timesOf(const Settings& settings, Send send, IsThere isThere, long& lost)
{
    std::vector<double> added_us;
    const auto all = static_cast<long>(settings.seconds * settings.rate_Hz);
    double next_s = base::steadySeconds();
    for (long k = 1; k <= all; ++k)
    {
        next_s = std::max(next_s + 1.0 / settings.rate_Hz, base::steadySeconds());
        std::this_thread::sleep_for(std::chrono::duration<double>(next_s - base::steadySeconds()));
        const double begin_s = base::steadySeconds();
        send(k, begin_s);
        double now_s = begin_s;
        bool arrived = false;
        while (!arrived && now_s < begin_s + bridge::OscInbox::kLost_s)
        {
            arrived = isThere(k);
            now_s = base::steadySeconds();
            if (!arrived) std::this_thread::yield();
        }
        if (arrived)
            added_us.push_back(1e6 * (now_s - begin_s));
        else
            ++lost;
    }
    return added_us;
}

void print(const std::string& what,
           const std::vector<double>& added_us,
           long lost,
           unsigned long long ignored)
{
    std::printf("%-22s %8zu %6ld %9.0f %9.0f %9.0f %9.0f %9llu\n",
                what.c_str(),
                added_us.size(),
                lost,
                base::percentile(added_us, 0.5),
                base::percentile(added_us, 0.99),
                base::percentile(added_us, 0.999),
                base::percentile(added_us, 1.0),
                ignored);
}

void measureHands(const Settings& settings, double flood_Hz)
{
    bridge::OscOptions options;
    options.port = 0;
    bridge::OscHandSource source(options);
    while (source.receiver().port() == 0)
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
    options.port = source.receiver().port();
    bridge::OscSender sender(options);
    const Flood flood(options.port, flood_Hz);
    bridge::HandFrame frame;
    double tip_m = 0.0;
    long lost = 0;
    const std::vector<double> added_us = timesOf(
        settings,
        [&](long k, double now_s)
        {
            const std::vector<bridge::Hand> hands = twoHands(k);
            tip_m = hands[1].joints[bridge::INDEX_TIP].position.x();
            sender.send(hands, now_s);
        },
        [&](long)
        {
            return source.frameAt(0.0, frame) && frame.hands.size() == 2 &&
                   std::abs(frame.hands[1].joints[bridge::INDEX_TIP].position.x() - tip_m) < 1e-5;
        },
        lost);
    const bridge::OscCounts counts = source.receiver().inbox().counts();
    print(flood_Hz > 0.0 ? "hands, flood " + std::to_string(static_cast<int>(flood_Hz)) + " Hz"
                         : "hands",
          added_us,
          lost,
          counts.malformed + counts.ofOthers);
}

/// The same datagrams from a thread to another that does nothing with them: what the system takes.
void measurePlain(const Settings& settings)
{
    const int socket = ::socket(AF_INET, SOCK_DGRAM, 0);
    const bridge::SocketAddress any = bridge::SocketAddress::parse("127.0.0.1", 0);
    ::bind(socket, any.get(), any.size());
    const bridge::SocketAddress there = bridge::SocketAddress::boundTo(socket);
    std::atomic<long> arrived{0};
    std::thread receiver(
        [&]
        {
            std::vector<char> bytes(65536);
            long number = 0;
            while (::recv(socket, bytes.data(), bytes.size(), 0) >=
                   static_cast<ssize_t>(sizeof number))
            {
                std::copy_n(bytes.data(), sizeof number, reinterpret_cast<char*>(&number));
                arrived = number;
            }
        });
    const int from = ::socket(AF_INET, SOCK_DGRAM, 0);
    std::vector<char> bytes(2600);
    const auto send = [&](long k, double /*now_s*/)
    {
        std::copy_n(reinterpret_cast<const char*>(&k), sizeof k, bytes.data());
        ::sendto(from, bytes.data(), bytes.size(), 0, there.get(), there.size());
    };
    long lost = 0;
    const std::vector<double> added_us = timesOf(
        settings, send, [&](long k) { return arrived == k; }, lost);
    ::sendto(from, bytes.data(), 0, 0, there.get(), there.size()); // ends the receiver
    receiver.join();
    ::close(from);
    ::close(socket);
    print("datagrams alone", added_us, lost, 0);
}

} // namespace

int main(int argc, char** argv)
{
    Settings settings;
    CLI::App app("Measures the latency of two hands by OSC over UDP on this machine.");
    app.add_option("--seconds", settings.seconds, "duration per line, s")
        ->check(CLI::Range(0.1, 3600.0));
    app.add_option("--rate", settings.rate_Hz, "Hz")->check(CLI::Range(1.0, 1000.0));
    CLI11_PARSE(app, argc, argv);
    std::printf("two hands at %.0f Hz on loopback, from sending to the hand source\n",
                settings.rate_Hz);
    std::printf("%-22s %8s %6s %9s %9s %9s %9s %9s\n",
                "",
                "arrived",
                "lost",
                "p50/us",
                "p99/us",
                "p99.9/us",
                "max/us",
                "ignored");
    measurePlain(settings);
    for (const double flood_Hz : {0.0, 1000.0, 10000.0})
        measureHands(settings, flood_Hz);
    return 0;
}
