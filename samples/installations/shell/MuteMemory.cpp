#include "samples/installations/shell/MuteMemory.h"

#include "samples/shared/shards/LineJournal.h"

#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <system_error>
#include <utility>

#include <fcntl.h>
#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <sys/file.h>
#include <unistd.h>

namespace midair::samples
{

MuteMemory::MuteMemory(std::string file, double now_s) : _file(std::move(file))
{
    if (_file.empty()) return;
    lockFile();
    const base::Lock lock(_changing);
    std::error_code ignored;
    if (std::filesystem::exists(_file, ignored) || ignored) read(now_s);
    if (write() || !_reason.empty()) return;
    _isWritable = false;
    _reason = fmt::format("\"{}\" can't be written: a restart will not remember a mute", _file);
}

MuteMemory::~MuteMemory()
{
    if (_lock >= 0) ::close(_lock);
}

// Without a lock, two programs would count each other as crashes. The file itself is replaced at
// each change, so a separate file is locked. If that can't be created, the state file isn't
// writable either.
void MuteMemory::lockFile()
{
    const std::string beside = _file + ".lock";
    _lock = ::open(beside.c_str(), O_WRONLY | O_CREAT | O_NOFOLLOW | O_CLOEXEC, 0644);
    if (_lock < 0 || ::flock(_lock, LOCK_EX | LOCK_NB) == 0) return;
    ::close(_lock);
    throw std::runtime_error("\"" + _file + "\" is in use by another program");
}

void MuteMemory::read(double now_s)
{
    try
    {
        std::ifstream in(_file);
        const nlohmann::json kept = nlohmann::json::parse(in);
        const bool wasMuted = kept.at("muted").get<bool>();
        for (const double crash_s : kept.at("crashes").get<std::vector<double>>())
            if (std::abs(now_s - crash_s) < kCrashTime_s) _crashes_s.push_back(crash_s);
        if (kept.at("running").get<bool>()) _crashes_s.push_back(now_s);
        _isMuted = wasMuted;
        if (_isMuted) _reason = "it was muted before the restart";
        if (_crashes_s.size() < kCrashes) return;
        _isMuted = true;
        _reason = fmt::format(
            "it crashed {} times in {:.0f} minutes", _crashes_s.size(), kCrashTime_s / 60.0);
    }
    catch (const std::exception&)
    {
        _isMuted = true;
        _reason = fmt::format("\"{}\" is invalid", _file);
    }
}

bool MuteMemory::keep(bool isMuted)
{
    const base::Lock lock(_changing);
    _isMuted = isMuted;
    if (!isMuted) _crashes_s.clear();
    return write();
}

bool MuteMemory::begin()
{
    const base::Lock lock(_changing);
    _isRunning = !_hasEnded;
    return write();
}

bool MuteMemory::end()
{
    const base::Lock lock(_changing);
    _isRunning = false;
    _hasEnded = true;
    return write();
}

// Keeps the old file until the new one and its name are on disk, because an operator may cut the
// power right after muting.
bool MuteMemory::write() const
{
    if (_file.empty()) return true;
    const nlohmann::ordered_json kept = {
        {"muted", _isMuted}, {"running", _isRunning}, {"crashes", _crashes_s}};
    const std::string text = kept.dump() + "\n";
    const std::string fresh = _file + ".new";
    const int descriptor =
        ::open(fresh.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_NOFOLLOW | O_CLOEXEC, 0644);
    if (descriptor < 0) return false;
    const bool isWritten =
        ::write(descriptor, text.data(), text.size()) == static_cast<ssize_t>(text.size()) &&
        ::fsync(descriptor) == 0;
    ::close(descriptor);
    if (!isWritten || std::rename(fresh.c_str(), _file.c_str()) != 0) return false;
    syncFolderOf(_file);
    return true;
}

} // namespace midair::samples
