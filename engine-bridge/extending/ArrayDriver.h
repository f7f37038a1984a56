#pragma once

#include "device/ArrayDevice.h"

#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

namespace midair::bridge
{

/// Driver of an array that the libraries don't know: levels in, state out. Derive from it and
/// register it under a scheme; openDevice() then opens "mine:PATH?key=value" with the limits of all
/// devices, which are taken off the URI.
///
/// Its functions are called on threads of the libraries' own, one call at a time, and nobody waits
/// for them: while a call runs the newest field waits, those before it are dropped, and a silence
/// comes before the next play(). What should become quieter has to be so within 100 ms, or 2.5
/// fields of fieldsPerSecond(): if play() hasn't returned true by then, the device is silenced,
/// which counts as a fault. A call of more than 1 s counts as a fault until it returns; who
/// closes the device waits at most 3 s. What leaves play() as an exception is a fault, and the
/// field is lost; what leaves isReady() means that the device is lost.
class ArrayDriver
{
public:
    virtual ~ArrayDriver() = default;

    /// Opens the device; called once, before all others. \a path: what stands between the URI's
    /// colon and its question mark. \a options: its parameters but for the limits. Returns false,
    /// with the reason in \a error, if it can't be opened or takes no such path, parameter or
    /// layout.
    virtual bool open(const std::string& path,
                      const std::map<std::string, std::string>& options,
                      const device::DeviceLayout& layout,
                      std::string& error) = 0;

    /// Plays a field until the next one, or silence(). Both arrays have an entry for each
    /// transducer: level L of \a phases means e^{+j 2 pi L/phaseLevels()}, \a amplitudes is an
    /// index into amplitudes(). Returns false if the device doesn't take it.
    virtual bool play(const unsigned char* phases, const unsigned char* amplitudes) = 0;

    /// Turns all transducers off, now; throws if that failed. It is then called again, and there is
    /// no play() until it returns.
    virtual void silence() = 0;

    /// Returns false while the device is lost. Asked some times a second and with every field.
    virtual bool isReady() const { return true; }

    /// Returns one line about the device's state, without its name.
    virtual std::string getStatus() const { return {}; }

    /// Number of phases that it can play, 2 .. 256. The same after every open().
    virtual unsigned int phaseLevels() const { return 256; }

    /// Relative amplitudes that it can play, rising from 0 to 1, 2 .. 256 of them; empty: 256, of
    /// which L is sin(pi L/510).
    virtual std::vector<float> amplitudes() const { return {}; }

    /// The most fields a second that it can take, >= 0; 0: any number.
    virtual double fieldsPerSecond() const { return 0.0; }
};

/// Makes a driver, which is then opened; null counts as a device that can't be opened.
using ArrayDriverFactory = std::function<std::shared_ptr<ArrayDriver>()>;

/// Registers the scheme \a scheme, 1 .. 32 small letters, for the rest of the program. Returns
/// false, with the reason in \a error, if it has another form or is taken. From any thread.
bool registerDriver(const std::string& scheme, ArrayDriverFactory make, std::string& error);

} // namespace midair::bridge
