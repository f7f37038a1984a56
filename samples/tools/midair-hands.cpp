// Sends hands and the head to a scene in another program as OSC messages, from a recording or a
// tracker, or shows the messages that arrive. The kit starts it as a helper for
// "openxr:?process=helper", for programs that have their own OpenXR session.

#include "samples/shared/ToolOptions.h"
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

using namespace midair::samples;
using Clock = std::chrono::steady_clock;

struct Settings
{
    std::string from;        ///< send: a recording; other commands: a hand source
    std::string to = "osc:"; ///< a receiver's name
    int socket = -1;         ///< inherited socket to use instead
    double rate_Hz = 250.0;  ///< messages per second
    double seconds = 0.0;    ///< 0: no end
    bool repeats = false;
    bool endsWithHands = false; ///< stop after the last hands
};

/// A recording ends after so long (s) without hands, because a source doesn't report its length.
constexpr double kEnd_s = 3.0;

double now()
{
    return std::chrono::duration<double>(Clock::now().time_since_epoch()).count();
}

/// Prints the source's messages, or sends them if there is a receiver for them.
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

/// Calls \a turn at the rate until it returns false, a signal arrives or the time is over.
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

/// Sends hands and heads until the receiver is gone, if that can be detected. \a heads is null if
/// there are only hands.
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
    double seen = -1.0; // time of the last hands; -1: none yet
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
    if (lost > 0) std::cout << "; the system refused " << lost << " not";
    std::cout << "\n";
}

/// Prints a line per second about the messages that arrive.
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
        if (error.empty()) error = "\"" + from + "\" is not a hand source";
        if (sender) sender->say(error);
        std::cerr << "midair-hands: " << error << "\n";
        return EXIT_WRONG;
    }
    return EXIT_DONE;
}

void addRate(CLI::App& command, Settings& settings)
{
    command.add_option("--rate", settings.rate_Hz, "datagrams per second")
        ->check(CLI::Range(1.0, 1000.0))
        ->capture_default_str();
    command.add_option("--seconds", settings.seconds, "duration, s; 0: no end")
        ->check(CLI::Range(0.0, 1e6))
        ->capture_default_str();
}

} // namespace

int main(int argc, char** argv)
try
{
    Settings settings;
    CLI::App app(
        "Sends hands and heads to a scene as OSC messages, or shows the messages that arrive.\n"
        "Example: midair-hands send star.csv --loop --to osc:?port=9000");
    app.require_subcommand(1);
    CLI::App& send = *app.add_subcommand("send", "send a recording");
    send.add_option("RECORDING", settings.from, "a hand recording")->required();
    send.add_option("--to", settings.to, "the receiver: osc:?address=127.0.0.1&port=9000")
        ->capture_default_str();
    send.add_flag("--loop", settings.repeats, "repeat it from the start");
    addRate(send, settings);
    CLI::App& relaying = *app.add_subcommand("relay", "send the hands and the head of a source");
    relaying.add_option("SOURCE", settings.from, "openxr:, openxr:?space=local, ..")->required();
    relaying.add_option("--to", settings.to, "the receiver")->capture_default_str();
    relaying
        .add_option("--socket",
                    settings.socket,
                    "send to this inherited socket instead, as the kit's helper")
        ->check(CLI::Range(3, 1023));
    addRate(relaying, settings);
    CLI::App& listening = *app.add_subcommand("listen", "show what arrives, one line per second");
    listening.add_option("SOURCE", settings.from, "osc:?port=9000, or another source")->required();
    addRate(listening, settings);
    int status = EXIT_DONE;
    if (!parseTool(app, argc, argv, status)) return status;
    settings.endsWithHands = send.parsed() && !settings.repeats;

    midair::samples::catchStopSignals();
    // A helper ends with its socket: Ctrl-C in a terminal is meant for the program that started it.
    if (settings.socket >= 0) std::signal(SIGINT, SIG_IGN);
    // Mute signals may go to the whole process group.
    if (settings.socket >= 0)
        for (const int number : {SIGUSR1, SIGUSR2})
            std::signal(number, SIG_IGN);
    // If a runtime hangs, the helper still ends with the program that started it.
    if (settings.socket >= 0) ::prctl(PR_SET_PDEATHSIG, SIGKILL);
    return run(app.get_subcommands().front()->get_name(), settings);
}
catch (const std::exception& problem)
{
    std::fprintf(stderr, "midair-hands: %s\n", problem.what());
    return EXIT_WRONG;
}
