//! The threads that compute. Nothing heavy ever runs on a tokio thread: it is queued here.

use std::any::Any;
use std::collections::VecDeque;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;

use thiserror::Error;
use toile_drape::network::Networks;
use tokio::sync::oneshot;

/// Why a job has no result.
#[derive(Clone, Copy, Debug, Error, PartialEq, Eq)]
pub enum WorkError {
    /// The queue holds as many jobs as it may.
    #[error("the queue is full")]
    Full,
    /// The workers are stopping.
    #[error("the workers are stopping")]
    Stopping,
    /// The job panicked.
    #[error("the computation panicked")]
    Panicked,
}

/// Work whose receiver may lose interest before it begins.
trait Job: Send {
    fn is_abandoned(&self) -> bool;
    fn run(self: Box<Self>, networks: &mut dyn Networks);
}

struct Task<T, F> {
    work: F,
    result: oneshot::Sender<T>,
}

impl<T: Send, F: FnOnce(&mut dyn Networks) -> T + Send> Job for Task<T, F> {
    fn is_abandoned(&self) -> bool {
        self.result.is_closed()
    }

    fn run(self: Box<Self>, networks: &mut dyn Networks) {
        // Nobody waits any more when this fails, and then nobody needs the result.
        let _ = self.result.send((self.work)(networks));
    }
}

struct Waiting {
    jobs: VecDeque<Box<dyn Job>>,
    open: bool,
}

/// A bounded queue of jobs. Abandoned jobs give up their place before a new one is refused.
struct Queue {
    waiting: Mutex<Waiting>,
    changed: Condvar,
    capacity: usize,
}

impl Queue {
    fn lock(&self) -> MutexGuard<'_, Waiting> {
        self.waiting.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn push(&self, job: Box<dyn Job>) -> Result<(), WorkError> {
        let mut waiting = self.lock();
        if !waiting.open {
            return Err(WorkError::Stopping);
        }
        if waiting.jobs.len() >= self.capacity {
            waiting.jobs.retain(|job| !job.is_abandoned());
        }
        if waiting.jobs.len() >= self.capacity {
            return Err(WorkError::Full);
        }
        waiting.jobs.push_back(job);
        self.changed.notify_one();
        Ok(())
    }

    /// The next job that somebody still waits for; nothing once the queue is closed and empty.
    fn pop(&self) -> Option<Box<dyn Job>> {
        let mut waiting = self.lock();
        loop {
            while let Some(job) = waiting.jobs.pop_front() {
                if !job.is_abandoned() {
                    return Some(job);
                }
            }
            if !waiting.open {
                return None;
            }
            waiting = self.changed.wait(waiting).unwrap_or_else(PoisonError::into_inner);
        }
    }

    fn close(&self) {
        self.lock().open = false;
        self.changed.notify_all();
    }
}

/// A fixed set of threads, each with networks of its own, fed by one bounded queue.
pub struct Workers {
    queue: Arc<Queue>,
    threads: Mutex<Vec<JoinHandle<()>>>,
}

impl Workers {
    /// Starts one thread for each set of networks; at most `capacity` jobs wait.
    ///
    /// # Errors
    /// When a thread cannot be started.
    pub fn start<N: Networks + 'static>(networks: Vec<N>, capacity: usize) -> std::io::Result<Self> {
        let waiting = Mutex::new(Waiting { jobs: VecDeque::new(), open: true });
        let queue = Arc::new(Queue { waiting, changed: Condvar::new(), capacity: capacity.max(1) });
        let mut threads = Vec::new();
        for (index, mut networks) in networks.into_iter().enumerate() {
            let queue = Arc::clone(&queue);
            let thread = std::thread::Builder::new().name(format!("worker-{index}"));
            threads.push(thread.spawn(move || work(&queue, &mut networks))?);
        }
        Ok(Self { queue, threads: Mutex::new(threads) })
    }

    /// Computes `work` on a worker thread. Dropping the future before the work begins cancels it.
    ///
    /// # Errors
    /// When the queue is full or closed, or the work panics.
    pub async fn run<T, F>(&self, work: F) -> Result<T, WorkError>
    where
        T: Send + 'static,
        F: FnOnce(&mut dyn Networks) -> T + Send + 'static,
    {
        let (result, answer) = oneshot::channel();
        let span = tracing::Span::current();
        let work = move |networks: &mut dyn Networks| span.in_scope(|| work(networks));
        self.queue.push(Box::new(Task { work, result }))?;
        answer.await.map_err(|_| WorkError::Panicked)
    }

    /// Finishes what is queued, then ends the threads.
    pub fn stop(&self) {
        self.queue.close();
        let threads = std::mem::take(&mut *self.threads.lock().unwrap_or_else(PoisonError::into_inner));
        for thread in threads {
            if let Err(panic) = thread.join() {
                tracing::error!(panic = panic_message(&*panic), "worker thread died");
            }
        }
    }
}

fn work(queue: &Queue, networks: &mut dyn Networks) {
    while let Some(job) = queue.pop() {
        if let Err(panic) = catch_unwind(AssertUnwindSafe(|| job.run(networks))) {
            tracing::error!(panic = panic_message(&*panic), "computation panicked");
        }
    }
}

/// The text of a panic, if it has one.
pub fn panic_message(panic: &(dyn Any + Send)) -> &str {
    let text = panic.downcast_ref::<&str>().copied();
    text.or_else(|| panic.downcast_ref::<String>().map(String::as_str)).unwrap_or("no message")
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::{AtomicUsize, Ordering};
    use std::sync::mpsc;

    use toile_drape::network::{NetworkError, Tensor, TensorRef};

    use super::*;

    struct NoNetworks;

    impl Networks for NoNetworks {
        fn run(&mut self, graph: &str, _: &[(&str, TensorRef<'_>)]) -> Result<Vec<Tensor>, NetworkError> {
            Err(NetworkError { graph: graph.into(), reason: "none here".into() })
        }

        fn fingerprint(&self) -> &str {
            "none"
        }
    }

    /// Occupies the only worker until the returned sender is dropped.
    fn block(workers: &Arc<Workers>) -> (mpsc::Sender<()>, tokio::task::JoinHandle<Result<(), WorkError>>) {
        let (release, wait) = mpsc::channel::<()>();
        let (started, starts) = mpsc::channel();
        let owned = Arc::clone(workers);
        let job = tokio::spawn(async move {
            owned
                .run(move |_| {
                    started.send(()).unwrap();
                    let _ = wait.recv();
                })
                .await
        });
        tokio::task::block_in_place(|| starts.recv().unwrap());
        (release, job)
    }

    #[tokio::test(flavor = "multi_thread", worker_threads = 2)]
    async fn a_full_queue_refuses_and_an_abandoned_job_makes_room() {
        let workers = Arc::new(Workers::start(vec![NoNetworks], 1).unwrap());
        let (release, blocked) = block(&workers);
        let ran = Arc::new(AtomicUsize::new(0));
        let counted = Arc::clone(&ran);
        let mut waiting = Box::pin(workers.run(move |_| counted.fetch_add(1, Ordering::SeqCst)));
        let poll = std::future::poll_fn(|context| std::task::Poll::Ready(waiting.as_mut().poll(context)));
        assert!(poll.await.is_pending());
        assert_eq!(workers.run(|_| ()).await, Err(WorkError::Full));
        drop(waiting);
        let replacement = workers.run(|_| 7);
        drop(release);
        assert_eq!(replacement.await, Ok(7));
        assert_eq!(ran.load(Ordering::SeqCst), 0, "an abandoned job was computed");
        blocked.await.unwrap().unwrap();
    }

    #[tokio::test]
    async fn a_panic_is_reported_and_the_worker_lives_on() {
        let workers = Workers::start(vec![NoNetworks], 4).unwrap();
        assert_eq!(workers.run(|_| -> u8 { panic!("on purpose") }).await, Err(WorkError::Panicked));
        assert_eq!(workers.run(|_| 3).await, Ok(3));
    }

    #[tokio::test]
    async fn stopped_workers_refuse() {
        let workers = Workers::start(vec![NoNetworks], 4).unwrap();
        workers.stop();
        assert_eq!(workers.run(|_| ()).await, Err(WorkError::Stopping));
    }
}
