#pragma once

#include <array>
#include <csignal>
#include <cstddef>
#include <cstdlib>
#include <string>

#include <fcntl.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

/// A display in memory for the rest of the program, which it is the DISPLAY of. Returns false if
/// there is none to be had.
inline bool useXvfb()
{
    struct Server
    {
        Server()
        {
            std::array<int, 2> ends{};
            if (pipe(ends.data()) != 0) return;
            pid = fork();
            if (pid == 0)
            {
                close(ends[0]);
                prctl(PR_SET_PDEATHSIG, SIGTERM); // with a test that crashes, too
                const int nowhere = open("/dev/null", O_RDWR);
                for (const int end : {0, 1, 2})
                    dup2(nowhere, end);
                const std::string number = std::to_string(ends[1]);
                // Without -noreset it resets itself whenever its last window goes.
                execlp("Xvfb",
                       "Xvfb",
                       "-displayfd",
                       number.c_str(),
                       "-noreset",
                       "-screen",
                       "0",
                       "800x600x24",
                       "-nolisten",
                       "tcp",
                       static_cast<char*>(nullptr));
                _exit(127);
            }
            close(ends[1]);
            std::array<char, 16> text{};
            // A number and the end of its line, perhaps one after the other.
            std::size_t count = 0;
            while (count + 1 < text.size() && read(ends[0], &text[count], 1) == 1 &&
                   text[count] != '\n')
                ++count;
            close(ends[0]);
            isThere = pid > 0 && count > 0;
            const int number = std::atoi(text.data());
            if (isThere) setenv("DISPLAY", (":" + std::to_string(number)).c_str(), 1);
        }
        ~Server()
        {
            if (pid <= 0) return;
            kill(pid, SIGTERM);
            waitpid(pid, nullptr, 0);
        }
        Server(const Server&) = delete;
        Server& operator=(const Server&) = delete;

        pid_t pid = -1;
        bool isThere = false;
    };
    static const Server server;
    return server.isThere;
}
