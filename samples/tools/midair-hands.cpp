// Sends hands and the head to a scene in another program, as OSC messages: those of a recording, or
// of a tracker that the kit knows; and shows what arrives. The kit starts it as a helper for
// "openxr:?process=helper", for programs that have their own OpenXR session.

#include "samples/shared/views/Signals.h"

#include <osgMidair/HandSender>
#include <osgMidair/HandSource>
#include <osgMidair/HeadSource>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <exception>
#include <iostream>
#include <string>
#include <thread>
#include <vector>

#include <CLI/CLI.hpp>
#include <sys/prctl.h>

namespace
{

using Clock = std::chrono::steady_clock;

enum ExitCode
{
    DONE = 0,
    WRONG_INPUT = 2
};

struct Settings
{
    std::string from;        ///< of send: a recording; of others a hand source's name
    std::string to = "osc:"; ///< a receiver's name
    int socket = -1;         ///< that was inherited, instead
    double rate_Hz = 250.0;  ///< sent in a second
    double seconds = 0.0;    ///< 0: without an end
    bool repeats = false;
    bool endsWithHands = false; ///< there is nothing to send after the last of them
};

/// A recording without hands for so long (s) is over: a source doesn't tell how long it is.
constexpr double kEnd_s = 3.0;

double now()
{
    return std::chrono::duration<double>(Clock::now().time_since_epoch()).count();
}

/// Prints what the source has to say, and sends it on where there is somebody to read it.
void tell(osgMidair::HandSource& source, osgMidair::HandSender* sender)
{
    for (const std::string& message : source.takeMessages())
    {
        if (sender)
            sender->say(message);
        else
            std::cerr << "midair-hands: " << message << std::endl;
    }
}

/// Calls \a turn at the rate until it returns false, a signal comes or the time is over.
template<typename Turn>
void atRate(const Settings& settings, Turn turn)
{
    const auto begin = Clock::now();
    const auto step = std::chrono::duration<double>(1.0 / settings.rate_Hz);
    for (long k = 0; !midair::samples::isStopAsked(); ++k)
    {
        const double time = static_cast<double>(k) / settings.rate_Hz;
        if (settings.seconds > 0.0 && time >= settings.seconds) return;
        std::this_thread::sleep_until(begin +
                                      std::chrono::duration_cast<Clock::duration>(k * step));
        if (!turn(time)) return;
    }
}

/// Sends what the sources give, until the receiver is gone where it can be known. \a heads: null
/// where there are hands alone.
void relay(const Settings& settings,
           osgMidair::HandSource& source,
           osgMidair::HeadSource* heads,
           osgMidair::HandSender& sender)
{
    osgMidair::Head head;
    std::vector<osgMidair::Hand> hands;
    long sent = 0;
    long lost = 0;
    double horizon = 0.0;
    double seen = -1.0; // when there were hands last; -1: not yet
    const bool isHelper = settings.socket >= 0;
    atRate(settings,
           [&](double time)
           {
               if (!sender.listen()) return false;
               if (sender.getHorizon() != horizon) source.setHorizon(horizon = sender.getHorizon());
               if (source.getHands(time, hands))
                   seen = time;
               else
                   hands.clear();
               if (settings.endsWithHands && seen >= 0.0 && time - seen > kEnd_s) return false;
               if (sender.send(hands, now()))
                   ++sent;
               else
                   ++lost;
               if (heads && heads->getHead(time, head)) sender.send(head, now());
               tell(source, isHelper ? &sender : nullptr);
               return true;
           });
    if (isHelper) return;
    std::cout << "sent " << sent << " datagrams to " << settings.to;
    if (lost > 0) std::cout << "; the system took " << lost << " not";
    std::cout << "\n";
}

/// Prints a line a second of what arrives.
void listen(const Settings& settings, osgMidair::HandSource& source)
{
    std::vector<osgMidair::Hand> hands;
    Settings each = settings;
    each.rate_Hz = std::min(settings.rate_Hz, 1.0);
    atRate(each,
           [&](double time)
           {
               if (!source.getHands(time, hands)) hands.clear();
               std::cout << hands.size() << (hands.size() == 1 ? " hand; " : " hands; ")
                         << source.getStatus() << std::endl;
               tell(source, nullptr);
               return true;
           });
}

int run(const std::string& command, const Settings& settings)
{
    std::string error;
    const std::string from = command == "send"
                                 ? "recorded:" + settings.from + (settings.repeats ? "?loop" : "")
                                 : settings.from;
    const osg::ref_ptr<osgMidair::HandSource> source = osgMidair::openHandSource(from, error);
    osg::ref_ptr<osgMidair::HandSender> sender;
    if (settings.socket >= 0)
        sender = osgMidair::HandSender::into(settings.socket);
    else if (source && command != "listen")
        sender = osgMidair::HandSender::open(settings.to, error);
    if (source && command == "listen")
        listen(settings, *source);
    else if (source && sender)
    {
        std::string none; // why there is no head; hands are enough
        const osg::ref_ptr<osgMidair::HeadSource> heads =
            settings.socket < 0 ? osgMidair::openHeadSource(from, none) : nullptr;
        relay(settings, *source, heads, *sender);
    }
    else
    {
        if (error.empty()) error = "\"" + from + "\" names no hands";
        if (sender) sender->say(error);
        std::cerr << "midair-hands: " << error << "\n";
        return WRONG_INPUT;
    }
    return DONE;
}

void addRate(CLI::App& command, Settings& settings)
{
    command.add_option("--rate", settings.rate_Hz, "datagrams in a second, Hz")
        ->check(CLI::Range(1.0, 1000.0))
        ->capture_default_str();
    command.add_option("--seconds", settings.seconds, "how long; 0: without an end")
        ->check(CLI::Range(0.0, 1e6))
        ->capture_default_str();
}

} // namespace

int main(int argc, char** argv)
try
{
    Settings settings;
    CLI::App app("Sends hands and heads to a scene as OSC messages, or shows those that arrive.");
    app.require_subcommand(1);
    CLI::App& send = *app.add_subcommand("send", "send a recording");
    send.add_option("RECORDING", settings.from, "a file of hands")->required();
    send.add_option("--to", settings.to, "the receiver: osc:?address=127.0.0.1&port=9000")
        ->capture_default_str();
    send.add_flag("--loop", settings.repeats, "again from its end on");
    addRate(send, settings);
    CLI::App& relaying = *app.add_subcommand("relay", "send the hands of a source, and its head");
    relaying.add_option("SOURCE", settings.from, "openxr:, openxr:?space=local, ..")->required();
    relaying.add_option("--to", settings.to, "the receiver")->capture_default_str();
    relaying
        .add_option(
            "--socket", settings.socket, "send into this open file instead, as the kit's helper")
        ->check(CLI::Range(3, 1023));
    addRate(relaying, settings);
    CLI::App& listening = *app.add_subcommand("listen", "show what arrives, a line a second");
    listening.add_option("SOURCE", settings.from, "osc:?port=9000, or another source")->required();
    addRate(listening, settings);
    CLI11_PARSE(app, argc, argv);
    settings.endsWithHands = send.parsed() && !settings.repeats;

    midair::samples::catchStopSignals();
    // A helper ends when its socket does: Ctrl-C in a terminal is meant for the program it helps.
    if (settings.socket >= 0) std::signal(SIGINT, SIG_IGN);
    // A mute for the program that started it may be sent to its whole group.
    if (settings.socket >= 0)
        for (const int number : {SIGUSR1, SIGUSR2})
            std::signal(number, SIG_IGN);
    // A runtime may hang: then the helper ends with the program that needs it all the same.
    if (settings.socket >= 0) ::prctl(PR_SET_PDEATHSIG, SIGKILL);
    return run(app.get_subcommands().front()->get_name(), settings);
}
catch (const std::exception& problem)
{
    std::fprintf(stderr, "midair-hands: %s\n", problem.what());
    return WRONG_INPUT;
}
