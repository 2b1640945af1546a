//! The next item of a stream within a time, for a thread that has other work as well.

use futures::Stream;
use std::pin::Pin;
use std::sync::Arc;
use std::task::{Context, Poll, Wake, Waker};
use std::thread::Thread;
use std::time::{Duration, Instant};

/// Waker of a parked thread.
struct Unpark(Thread);

impl Wake for Unpark {
    fn wake(self: Arc<Self>) {
        self.0.unpark();
    }
}

/// Returns the next item; `None` where none comes within `patience`, or the stream has ended.
pub(super) fn next_within<S: Stream>(mut stream: Pin<&mut S>, patience: Duration) -> Option<S::Item> {
    let waker = Waker::from(Arc::new(Unpark(std::thread::current())));
    let (mut context, end) = (Context::from_waker(&waker), Instant::now() + patience);
    loop {
        if let Poll::Ready(item) = stream.as_mut().poll_next(&mut context) {
            return item;
        }
        let left = end.saturating_duration_since(Instant::now());
        if left.is_zero() {
            return None;
        }
        // It may return early: then the stream is asked again.
        std::thread::park_timeout(left);
    }
}
