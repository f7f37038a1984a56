#include "plugin/loader/ModelTrial.h"

#include "engine-bridge/hands/helper/HelperProcess.h"
#include "haptics/base/InputError.h"
#include "plugin/settings/Grants.h"

#include <osg/Notify>

#include <cerrno>
#include <map>
#include <mutex>

#include <poll.h>
#include <sys/socket.h>
#include <sys/stat.h>

namespace osgMidair
{

namespace
{

bool isSame(const struct stat& a, const struct stat& b)
{
    return a.st_ino == b.st_ino && a.st_size == b.st_size && a.st_mtim.tv_sec == b.st_mtim.tv_sec &&
           a.st_mtim.tv_nsec == b.st_mtim.tv_nsec;
}

std::string tried(const std::string& file, const std::string& options)
{
    constexpr int kPatience_ms = 120000;
    const std::string program = midair::bridge::programBeside("midair-check");
    if (program.empty())
    {
        OSG_INFO << "osgMidair: midair-check is not there, so " << printable(file)
                 << " is read without a trial" << std::endl;
        return {};
    }
    try
    {
        midair::bridge::HelperProcess trial({program, "--try", "--options=" + options, "--", file});
        pollfd answer{trial.socket(), POLLIN, 0};
        int ready = -1;
        do
            ready = ::poll(&answer, 1, kPatience_ms);
        while (ready < 0 && errno == EINTR);
        char read = 0;
        if (::recv(trial.socket(), &read, 1, 0) == 1) return {};
        if (ready == 0) return file + ": OpenSceneGraph's reader takes longer than two minutes";
        return file + ": the process that tried to read it " + trial.end() +
               ": the file is broken, or OpenSceneGraph's reader of it is";
    }
    catch (const midair::base::InputError& error)
    {
        OSG_NOTICE << "osgMidair: " << printable(file + " is read without a trial: " + error.what())
                   << std::endl;
        return {};
    }
}

} // namespace

// A file that was read and is as it was needs no second trial.
std::string whyNotToRead(const std::string& file, const std::string& options)
{
    static std::mutex mutex;
    static std::map<std::string, struct stat> files;
    struct stat now = {};
    if (::stat(file.c_str(), &now) == 0)
    {
        const std::lock_guard<std::mutex> lock(mutex);
        const auto then = files.find(file);
        if (then != files.end() && isSame(then->second, now)) return {};
    }
    const std::string why = tried(file, options);
    const std::lock_guard<std::mutex> lock(mutex);
    if (why.empty()) files[file] = now;
    return why;
}

} // namespace osgMidair
