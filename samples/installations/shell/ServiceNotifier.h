#pragma once

#include <string>

namespace midair::samples
{

/// Tells systemd, where the program runs as its service, that it is ready and that its frames go
/// on (sd_notify(3): datagrams to $NOTIFY_SOCKET). Elsewhere it does nothing.
class ServiceNotifier
{
public:
    ServiceNotifier();
    ~ServiceNotifier();
    ServiceNotifier(const ServiceNotifier&) = delete;
    ServiceNotifier& operator=(const ServiceNotifier&) = delete;

    /// To be called in each frame, at \a now_s of a steady clock. The first one says READY; a sign
    /// of life is sent three times in $WATCHDOG_USEC. \a status: a line for `systemctl status`.
    void beat(double now_s, const std::string& status);
    /// Says that the program is about to end.
    void stop();

private:
    void send(const std::string& text) const;

    int _socket = -1;
    double _interval_s = 1.0;
    double _last_s = -1e9;
    bool _isReady = false;
    std::string _address;
};

} // namespace midair::samples
