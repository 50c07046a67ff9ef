// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <arpa/inet.h>
#include <netinet/in.h>
#include <pwd.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <fstream>
#include <random>
#include <string>
#include <vector>

#include "cli/process.h"

namespace dttmm::host {

/// Slurm on this machine alone: munge, controller and one node with two cores, as the user of the test, on free ports of the
/// loopback. Its life is that of the object. SLURM_CONF of this process says where it is.
class OneNodeSlurm {
public:
    /// Whether the programs are there.
    static bool is_installed() {
        for (const char* program : {"/usr/sbin/munged", "/usr/sbin/slurmctld", "/usr/sbin/slurmd", "/usr/bin/sbatch"})
            if (::access(program, X_OK) != 0) return false;
        return true;
    }

    /// folder: new, and neither it nor its parents writable for others, or munge refuses it.
    explicit OneNodeSlurm(fs::path folder, int most_array = 20001) : folder_(std::move(folder)) {
        for (const char* name : {"state", "spool", "log", "run", "etc"}) fs::create_directories(folder_ / name);
        write_key();
        start({"/usr/sbin/munged", "-F", "--key-file=" + (folder_ / "etc/munge.key").string(),
               "--socket=" + socket().string(), "--pid-file=" + (folder_ / "run/munged.pid").string(),
               "--log-file=" + (folder_ / "log/munged.log").string(),
               "--seed-file=" + (folder_ / "state/munge.seed").string()});
        is_up_ = wait_until([&] { return fs::exists(socket()); });
        write_text(configuration(), configuration_text(most_array));
        ::setenv("SLURM_CONF", configuration().c_str(), 1);
        start({"/usr/sbin/slurmctld", "-D", "-c", "-f", configuration()});
        start({"/usr/sbin/slurmd", "-D", "-c", "-N", host(), "-f", configuration()});
        is_up_ = is_up_ && wait_until([&] { return output_of("sinfo -h -o %T").starts_with("idle"); });
    }
    ~OneNodeSlurm() {
        for (auto id = ids_.rbegin(); id != ids_.rend(); ++id) {  // the node first, munge last
            ::kill(*id, SIGTERM);
            ::waitpid(*id, nullptr, 0);
        }
        ::unsetenv("SLURM_CONF");
    }
    OneNodeSlurm(const OneNodeSlurm&) = delete;
    OneNodeSlurm& operator=(const OneNodeSlurm&) = delete;

    bool is_up() const { return is_up_; }
    static std::string output_of(const std::string& command) {
        std::string text;
        FILE* pipe = ::popen((command + " 2>&1").c_str(), "r");
        char buffer[4096];
        while (const size_t size = std::fread(buffer, 1, sizeof buffer, pipe)) text.append(buffer, size);
        ::pclose(pipe);
        return text;
    }

private:
    fs::path socket() const { return folder_ / "run/munge.socket"; }
    fs::path configuration() const { return folder_ / "etc/slurm.conf"; }
    static std::string host() {
        char name[256] = "";
        ::gethostname(name, sizeof name - 1);
        const std::string whole = name;
        return whole.substr(0, whole.find('.'));
    }
    static int free_port() {
        const int descriptor = ::socket(AF_INET, SOCK_STREAM, 0);
        sockaddr_in address{};
        address.sin_family = AF_INET;
        address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
        socklen_t size = sizeof address;
        ::bind(descriptor, reinterpret_cast<sockaddr*>(&address), size);
        ::getsockname(descriptor, reinterpret_cast<sockaddr*>(&address), &size);
        ::close(descriptor);
        return ntohs(address.sin_port);
    }
    void write_key() const {
        std::string key(1024, '\0');
        std::random_device random;
        for (char& c : key) c = static_cast<char>(random());
        write_text(folder_ / "etc/munge.key", key);
        fs::permissions(folder_ / "etc/munge.key", fs::perms::owner_read);
    }
    void start(const std::vector<std::string>& words) {
        std::vector<char*> arguments;
        for (const std::string& word : words) arguments.push_back(const_cast<char*>(word.c_str()));
        arguments.push_back(nullptr);
        const pid_t child = ::fork();
        if (child == 0) {
            const fs::path log = folder_ / "log" / (fs::path(words[0]).filename().string() + ".out");
            if (std::freopen(log.c_str(), "w", stdout) && std::freopen(log.c_str(), "a", stderr))
                ::execv(arguments[0], arguments.data());
            ::_exit(127);
        }
        ids_.push_back(child);
    }
    std::string configuration_text(int most_array) const {
        const std::string user = ::getpwuid(::getuid())->pw_name, d = folder_.string();
        const int node_port = free_port();
        std::string text;
        for (const auto& [key, value] :
             std::vector<std::pair<std::string, std::string>>{{"ClusterName", "test"},
                                                              {"SlurmctldHost", host() + "(127.0.0.1)"},
                                                              {"SlurmUser", user},
                                                              {"SlurmdUser", user},
                                                              {"AuthType", "auth/munge"},
                                                              {"AuthInfo", "socket=" + socket().string()},
                                                              {"CommunicationParameters", "NoCtldInAddrAny,NoInAddrAny"},
                                                              {"SlurmctldPort", std::to_string(free_port())},
                                                              {"SlurmdPort", std::to_string(node_port)},
                                                              {"StateSaveLocation", d + "/state"},
                                                              {"SlurmdSpoolDir", d + "/spool"},
                                                              {"SlurmctldPidFile", d + "/run/slurmctld.pid"},
                                                              {"SlurmdPidFile", d + "/run/slurmd.pid"},
                                                              {"ProctrackType", "proctrack/linuxproc"},
                                                              {"TaskPlugin", "task/none"},
                                                              {"JobAcctGatherType", "jobacct_gather/none"},
                                                              {"AccountingStorageType", "accounting_storage/none"},
                                                              {"MpiDefault", "none"},
                                                              {"SelectType", "select/cons_tres"},
                                                              {"SelectTypeParameters", "CR_Core"},
                                                              {"SchedulerParameters",
                                                               "sched_interval=1,sched_min_interval=0,"
                                                               "batch_sched_delay=0,bf_interval=1"},
                                                              {"ReturnToService", "2"},
                                                              {"KillWait", "2"},
                                                              {"MaxArraySize", std::to_string(most_array)},
                                                              {"MaxJobCount", "20000"}})
            text += key + "=" + value + "\n";
        const long cores = std::min(2L, ::sysconf(_SC_NPROCESSORS_ONLN));
        return text + "NodeName=" + host() + " NodeAddr=127.0.0.1 Port=" + std::to_string(node_port) +
               " CPUs=" + std::to_string(cores) + " RealMemory=500 State=UNKNOWN\nPartitionName=all Nodes=" + host() +
               " Default=YES MaxTime=INFINITE State=UP\n";
    }

    fs::path folder_;
    std::vector<pid_t> ids_;
    bool is_up_ = false;
};

}  // namespace dttmm::host
